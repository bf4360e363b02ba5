#include "host/evaluate_report.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace adit::host {
namespace {

constexpr std::size_t kPointsMax = 1500;  // a series: more only makes the page heavy
constexpr std::size_t kSigmaClasses = 12;
constexpr std::array kTargetMarks{PlotMark::kDot, PlotMark::kRing, PlotMark::kTriangle, PlotMark::kCross};

ReportTable FigureTable(const Comparison& comparison) {
  ReportTable table{"figures",
                    "Errors by target and distance",
                    {{"target", "target"},
                     {"from_m", "from, m"},
                     {"to_m", "to, m"},
                     {"visible", "visible"},
                     {"tracked_pct", "tracked, %"},
                     {"rms_mm", "rms, mm"},
                     {"max_mm", "max, mm"},
                     {"bias_x_mm", "bias x, mm"},
                     {"bias_y_mm", "y"},
                     {"bias_z_mm", "z"},
                     {"nees", "NEES (3)"},
                     {"bar_mae_mm", "bar error, mm"},
                     {"xrms_p_mm", "xRMS(P), mm"},
                     {"flips", "flips"}},
                    {}};
  for (const Figures& f : comparison.figures) {
    const auto count = [](std::size_t n) { return ReportNumber(static_cast<double>(n), 0); };
    table.rows.push_back({ReportWords(f.target), ReportNumber(f.from_m, 0), ReportNumber(f.to_m, 0),
                          count(f.visible), ReportNumber(f.TrackedPct(), 2), ReportNumber(1e3 * f.rms_m, 2),
                          ReportNumber(1e3 * f.max_m, 2), ReportNumber(1e3 * f.bias_m.x(), 2),
                          ReportNumber(1e3 * f.bias_m.y(), 2), ReportNumber(1e3 * f.bias_m.z(), 2),
                          ReportNumber(f.nees, 2), ReportNumber(1e3 * f.bar_mae_m, 2),
                          ReportNumber(1e3 * f.bar_xrms_m, 2), count(f.flips)});
  }
  return table;
}

std::vector<std::string> TargetNames(const Comparison& comparison) {
  std::vector<std::string> names;
  for (const ComparedRow& row : comparison.rows) {
    if (std::find(names.begin(), names.end(), row.target) == names.end()) names.push_back(row.target);
  }
  return names;
}

/// One series for every target.
template <class PointOf>
std::vector<PlotSeries> ByTarget(const Comparison& comparison, PointOf point_of) {
  std::vector<PlotSeries> all;
  for (const std::string& name : TargetNames(comparison)) {
    PlotSeries series{name, kTargetMarks[all.size() % kTargetMarks.size()], {}, {}};
    for (const ComparedRow& row : comparison.rows) {
      if (row.target == name) series.points.push_back(point_of(row));
    }
    const std::size_t stride = 1 + series.points.size() / kPointsMax;
    for (std::size_t i = 0; i * stride < series.points.size(); ++i)
      series.points[i] = series.points[i * stride];
    series.points.resize((series.points.size() + stride - 1) / stride);
    all.push_back(std::move(series));
  }
  return all;
}

Plot ErrorPlot(const Comparison& comparison) {
  Plot plot;
  plot.title = "Position error against distance";
  plot.x.label = "distance, m", plot.y.label = "error in three dimensions, mm";
  plot.series = ByTarget(comparison, [](const ComparedRow& row) {
    return Eigen::Vector2d(row.truth_m.norm(), 1e3 * row.error_m.norm());
  });
  return plot;
}

Plot BarPlot(const Comparison& comparison) {
  Plot plot;
  plot.title = "Bar length against distance";
  plot.note = "Measured minus true, LEDs each on their own.";
  plot.x.label = "distance, m", plot.y.label = "error of the bar length, mm";
  plot.series = ByTarget(comparison, [](const ComparedRow& row) {
    return Eigen::Vector2d(row.truth_m.norm(), 1e3 * row.bar_error_m);
  });
  return plot;
}

Plot AbovePlot(const Comparison& comparison) {
  Plot plot;
  plot.title = "From above";
  plot.note = "Rig frame; the cross is the left camera, z its axis.";
  plot.same_scale = true;
  plot.x.label = "x, m", plot.y.label = "z, m";
  plot.series = ByTarget(comparison, [](const ComparedRow& row) {
    return Eigen::Vector2d(row.truth_m.x() + row.error_m.x(), row.truth_m.z() + row.error_m.z());
  });
  plot.series.push_back({"left camera", PlotMark::kCross, {{0, 0}}, {}});
  return plot;
}

/// Rows sorted by what they state, in classes of equal count: stated against real, both rms.
Plot StatedPlot(const Comparison& comparison) {
  std::vector<std::pair<double, double>> rows;
  for (const ComparedRow& row : comparison.rows)
    rows.emplace_back(1e3 * row.sigma_m.norm(), 1e3 * row.error_m.norm());
  std::sort(rows.begin(), rows.end());
  PlotSeries real{"rms of the rows that state it", PlotMark::kDot, {}, {}},
      ideal{"as stated", PlotMark::kDashedLine, {}, {}};
  for (std::size_t c = 0; c < kSigmaClasses && !rows.empty(); ++c) {
    const std::size_t from = c * rows.size() / kSigmaClasses, to = (c + 1) * rows.size() / kSigmaClasses;
    if (from == to) continue;
    double stated = 0, error = 0;
    for (std::size_t i = from; i < to; ++i)
      stated += rows[i].first * rows[i].first, error += rows[i].second * rows[i].second;
    const auto n = static_cast<double>(to - from);
    real.points.emplace_back(std::sqrt(stated / n), std::sqrt(error / n));
    real.sigma.push_back(std::sqrt(error / n / (2 * n)));
    ideal.points.emplace_back(std::sqrt(stated / n), std::sqrt(stated / n));
  }
  Plot plot;
  plot.title = "Stated against real error";
  plot.note =
      "Above the line the stated sigmas are too small: a calibration's own error is in the real one only.";
  plot.x.label = "stated standard deviation (3D), mm", plot.y.label = "real error, mm";
  plot.series = {real, ideal};
  return plot;
}

void PassVerdict(const Comparison& comparison, ReportPage& page) {
  constexpr double kTrackedPct = 99;  // fewer, and a reader must not miss it
  std::vector<std::string> wrong, missing;
  if (comparison.false_positions > 0)
    wrong.push_back(std::to_string(comparison.false_positions) + " positions of targets that were not there");
  std::size_t flips = 0;
  for (const Figures& f : comparison.figures) {
    flips += f.flips;
    const bool all_distances = f.from_m == 0 && f.to_m > 100;
    if (all_distances && f.visible > 0 && f.TrackedPct() < kTrackedPct)
      missing.push_back(f.target + ": " + std::to_string(f.visible - f.tracked) + " of " +
                        std::to_string(f.visible) + " times without a position, although visible");
  }
  if (flips > 0) wrong.emplace_back("directions against the truth's");
  if (!wrong.empty())
    page.Verdict(ReportVerdict::kBad, "Wrong positions were reported:", wrong);
  else if (!missing.empty())
    page.Verdict(ReportVerdict::kCaution,
                 "No false position, no direction turned, but positions are missing:", missing);
  else
    page.Verdict(ReportVerdict::kGood, "No false position, no direction turned.", {});
}

}  // namespace

ReportPage MakeEvaluateReport(const Comparison& comparison, const std::string& track,
                              const std::string& truth) {
  ReportPage page("evaluate", "Track against truth", track + " against " + truth);
  PassVerdict(comparison, page);
  page.Facts(
      {{"rows", "positions compared", ReportNumber(static_cast<double>(comparison.rows.size()), 0), ""},
       {"false_positions", "false positions",
        ReportNumber(static_cast<double>(comparison.false_positions), 0), ""}});
  page.Section("Errors");
  page.Add(FigureTable(comparison));
  page.Add(ErrorPlot(comparison));
  page.Add(StatedPlot(comparison));
  page.Add(BarPlot(comparison));
  page.Add(AbovePlot(comparison));
  return page;
}

}  // namespace adit::host
