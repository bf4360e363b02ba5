#include "host/intrinsics_report.h"

#include <algorithm>
#include <cmath>

namespace adit::host {
namespace {

constexpr std::size_t kVectorsMax = 1500;

ReportTable ParameterTable(const IntrinsicCalibration& c) {
  ReportTable table{
      "parameters", "Parameters", {{"name", "parameter"}, {"value", "value"}, {"sigma", "sigma"}}, {}};
  if (c.opencv)
    table.columns.insert(
        table.columns.end(),
        {{"opencv", "OpenCV"}, {"opencv_sigma", "its sigma"}, {"apart_sigmas", "apart by, sigmas"}});
  const IntrinsicVector value = Intrinsics(c.camera), sigma = c.Sigma();
  for (int i = 0; i < kIntrinsics; ++i) {
    const int decimals = i < 4 ? 3 : 6;
    const std::string name = kIntrinsicNames[static_cast<std::size_t>(i)];
    std::vector<ReportCell> row{ReportWords(i < 4 ? name + ", px" : name), ReportNumber(value[i], decimals),
                                ReportNumber(sigma[i], decimals)};
    if (c.opencv) {
      const double theirs = Intrinsics(c.opencv->camera)[i];
      row.insert(row.end(), {ReportNumber(theirs, decimals), ReportNumber(c.opencv->sigma[i], decimals),
                             ReportNumber((value[i] - theirs) / sigma[i], 2)});
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

ReportTable ImageTable(const IntrinsicCalibration& c) {
  ReportTable table{
      "images",
      "Images",
      {{"image", "image"}, {"corners", "corners"}, {"rms_px", "rms, px"}, {"left_out", "left out because"}},
      {}};
  for (const ImageReport& image : c.images) {
    table.rows.push_back({ReportWords(image.image), ReportNumber(static_cast<double>(image.corners), 0),
                          ReportNumber(image.left_out.empty() ? image.rms_px : std::nan(""), 3),
                          ReportWords(image.left_out)});
  }
  return table;
}

void FrameImage(const optics::CameraModel& camera, Plot& plot) {
  plot.same_scale = true;
  plot.x.label = "u, px", plot.y.label = "v, px";
  plot.x.range = {0, camera.width_px}, plot.y.range = {0, camera.height_px};
  plot.y.reversed = true;
}

Plot CoveragePlot(const IntrinsicCalibration& c) {
  Plot plot;
  plot.title = "Where corners were measured";
  plot.note = "Corners in 8 x 6 cells; hatched: none, there the distortion is extrapolated.";
  FrameImage(c.camera, plot);
  const CoverageMap map = c.Coverage();
  PlotCells cells{"corners",
                  CoverageMap::kColumns,
                  CoverageMap::kRows,
                  {},
                  {0, 0},
                  {c.camera.width_px, c.camera.height_px}};
  for (int row = 0; row < cells.rows; ++row) {
    for (int column = 0; column < cells.columns; ++column) cells.values.push_back(map.Count(column, row));
  }
  plot.cells.push_back(std::move(cells));
  return plot;
}

Plot ResidualPlot(const IntrinsicCalibration& c) {
  Plot plot;
  plot.title = "Residuals in the image";
  plot.note =
      "They must point anywhere: a common direction in one region is distortion that the model leaves.";
  FrameImage(c.camera, plot);
  PlotVectors vectors{"residual", "px", 1, {}, {}};
  const std::size_t stride = 1 + c.marks.size() / kVectorsMax;
  for (std::size_t i = 0; i < c.marks.size(); i += stride) {
    vectors.places.push_back(c.marks[i].image_px);
    vectors.steps.push_back(c.marks[i].residual_px);
  }
  vectors.magnified = RoundMagnification(vectors.steps, c.camera.width_px);
  plot.vectors.push_back(std::move(vectors));
  return plot;
}

Plot ResidualHistogram(const IntrinsicCalibration& c) {
  std::vector<double> coordinates;
  for (const CoverageMark& mark : c.marks)
    coordinates.insert(coordinates.end(), {mark.residual_px.x(), mark.residual_px.y()});
  Plot plot;
  plot.title = "Residuals of the coordinates";
  plot.x.label = "residual, px", plot.y.label = "coordinates";
  plot.histograms.push_back(HistogramOf("u and v of all corners used", coordinates, 40));
  return plot;
}

Plot ImagePlot(const IntrinsicCalibration& c) {
  Plot plot;
  plot.title = "Residuals by image";
  plot.x.label = "image, in the order of the table", plot.y.label = "rms, px";
  PlotSeries used{"used", PlotMark::kDot, {}, {}};
  for (std::size_t i = 0; i < c.images.size(); ++i) {
    if (c.images[i].left_out.empty())
      used.points.emplace_back(static_cast<double>(i + 1), c.images[i].rms_px);
  }
  plot.series.push_back(std::move(used));
  return plot;
}

}  // namespace

ReportPage MakeIntrinsicsReport(const IntrinsicCalibration& c, const Board& board) {
  ReportPage page("intrinsics", "Camera from images of a board",
                  board.Text() + "; " + std::to_string(c.ImagesUsed()) + " of " +
                      std::to_string(c.images.size()) + " images used");
  page.Verdict(c.warnings.empty() ? ReportVerdict::kGood : ReportVerdict::kCaution,
               c.warnings.empty() ? "Good." : "Usable, but:", c.warnings);
  page.Facts(
      {{"rms_px", "rms of a corner", ReportNumber(c.rms_px, 3), "px"},
       {"sigma0_px", "sigma of a coordinate", ReportNumber(c.sigma0_px, 3), "px"},
       {"dispersion", "dispersion between images", ReportNumber(c.dispersion, 2), ""},
       {"corners", "corners used", ReportNumber(static_cast<double>(c.corners), 0), ""},
       {"corners_left_out", "left out", ReportNumber(static_cast<double>(c.corners_left_out), 0), ""},
       {"coverage_pct", "cells with a corner", ReportNumber(c.Coverage().Pct(), 0), "%"},
       {"reach_pct", "out to, of half the diagonal", ReportNumber(100 * c.Coverage().Reach(), 0), "%"}});
  page.Section("Result");
  page.Add(ParameterTable(c));
  page.Section("Coverage and residuals");
  page.Add(CoveragePlot(c));
  page.Add(ResidualPlot(c));
  page.Add(ResidualHistogram(c));
  page.Add(ImagePlot(c));
  page.Section("Images");
  page.Add(ImageTable(c));
  return page;
}

}  // namespace adit::host
