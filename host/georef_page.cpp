#include "host/georef_page.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace adit::host {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kDegOfRadian = 180 / 3.14159265358979323846;

ReportTable ParameterTable(const Georeferencing& result) {
  ReportTable table{"solution",
                    "Projection centre of the left camera, and where its axis points",
                    {{"parameter", "parameter"}, {"value", "value"}, {"sigma", "sigma"}},
                    {}};
  const Vector3d place_m = result.fit.Apply(Vector3d::Zero()), place_sigma_m = OriginSigma(result);
  const Vector3d attitude_deg = kDegOfRadian * AttitudeOf(result.fit.R_s_b),
                 attitude_sigma_deg = kDegOfRadian * AttitudeSigma(result);
  const auto row = [&table](const char* name, int decimals, double value, double sigma) {
    table.rows.push_back({ReportWords(name), ReportNumber(value, decimals), ReportNumber(sigma, decimals)});
  };
  constexpr std::array kPlaces{"easting, m", "northing, m", "height, m"};
  constexpr std::array kAngles{"heading, deg", "pitch, deg", "roll, deg"};
  for (std::size_t i = 0; i < kPlaces.size(); ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    row(kPlaces[i], 4, place_m[axis], place_sigma_m[axis]);
  }
  for (std::size_t i = 0; i < kAngles.size(); ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    const bool is_given = i > 0 && !result.options.estimate_tilt;
    row(kAngles[i], 5, attitude_deg[axis], is_given ? std::nan("") : attitude_sigma_deg[axis]);
  }
  row("scale beside the grid's, ppm", 1, result.scale_ppm, result.SigmaFactor() * result.scale_sigma_ppm);
  return table;
}

ReportTable PointTable(const Georeferencing& result) {
  ReportTable table{"points",
                    "Control points, residuals control minus rig",
                    {{"name", "point"},
                     {"measured_as", "measured as"},
                     {"easting_m", "easting, m"},
                     {"northing_m", "northing, m"},
                     {"height_m", "height, m"},
                     {"residual_e_mm", "E, mm"},
                     {"residual_n_mm", "N"},
                     {"residual_h_mm", "H"},
                     {"residual_mm", "3D"},
                     {"left_out_mm", "left out: 3D, mm"},
                     {"test", "test"},
                     {"remark", ""}},
                    {}};
  const Snooping& snooping = result.snooping;
  for (std::size_t i = 0; i < result.points.size(); ++i) {
    const MatchedPoint& point = result.points[i];
    const Vector3d residual_mm = 1e3 * result.fit.Residual(point.common);
    const bool has_test = i < result.used && snooping.tests[i].left_out_m.has_value();
    const bool is_suspected = snooping.suspects_blunder && i < result.used && i == *snooping.worst;
    std::vector<ReportCell> row{ReportWords(point.common.name), ReportWords(point.rig_name)};
    for (const double value : point.common.control_s_m) row.push_back(ReportNumber(value, 4));
    for (const double value : residual_mm) row.push_back(ReportNumber(value, 1));
    row.push_back(ReportNumber(residual_mm.norm(), 1));
    row.push_back(ReportNumber(has_test ? 1e3 * snooping.tests[i].left_out_m->norm() : std::nan(""), 1));
    row.push_back(ReportNumber(has_test ? snooping.tests[i].left_out_test : std::nan(""), 2));
    row.push_back(ReportWords(is_suspected ? "blunder suspected" : point.used ? "" : "not used"));
    table.rows.push_back(std::move(row));
  }
  return table;
}

/// The plan, relative to the rig's origin so that the axes stay readable.
Plot PlanPlot(const Georeferencing& result) {
  const Vector2d origin = result.fit.Apply(Vector3d::Zero()).head<2>();
  Plot plot;
  plot.title = "Plan with residuals";
  plot.note = "Relative to the left camera, which stands at the cross; grid north is up.";
  plot.same_scale = true;
  plot.x.label = "easting from the rig, m", plot.y.label = "northing from the rig, m";
  PlotSeries used{"used", PlotMark::kSquare, {}, {}}, unused{"compared only", PlotMark::kTriangle, {}, {}};
  PlotVectors vectors{"residual", "m", 1, {}, {}};
  double extent_m = 1;
  for (const MatchedPoint& point : result.points) {
    const Vector2d place = point.common.control_s_m.head<2>() - origin;
    (point.used ? used : unused).points.push_back(place);
    vectors.places.push_back(place);
    vectors.steps.push_back(result.fit.Residual(point.common).head<2>());
    extent_m = std::max(extent_m, place.norm());
  }
  vectors.magnified = RoundMagnification(vectors.steps, 4 * extent_m);  // a tenth of the plan: few points
  plot.series = {used};
  if (!unused.points.empty()) plot.series.push_back(unused);
  plot.series.push_back({"left camera", PlotMark::kCross, {{0, 0}}, {}});
  plot.vectors.push_back(std::move(vectors));
  return plot;
}

Plot HoldOutPlot(const Georeferencing& result) {
  Plot plot;
  plot.title = "Fit against hold-out";
  plot.note = "A point that only fits because it takes part stands far above the line.";
  plot.x.label = "residual in the fit (3D), mm", plot.y.label = "residual when left out (3D), mm";
  PlotSeries points{"points", PlotMark::kDot, {}, {}}, line{"equal", PlotMark::kDashedLine, {{0, 0}}, {}};
  for (std::size_t i = 0; i < result.used; ++i) {
    const PointTest& test = result.snooping.tests[i];
    if (!test.left_out_m) continue;
    points.points.emplace_back(1e3 * test.residual_m.norm(), 1e3 * test.left_out_m->norm());
    line.points.emplace_back(points.points.back().x(), points.points.back().x());
  }
  std::sort(line.points.begin(), line.points.end(),
            [](const Vector2d& a, const Vector2d& b) { return a.x() < b.x(); });
  plot.series = {points, line};
  return plot;
}

Plot DistanceResidualPlot(const Georeferencing& result) {
  Plot plot;
  plot.title = "Residuals against distance from the rig";
  plot.x.label = "distance, m", plot.y.label = "residual, mm";
  PlotSeries horizontal{"horizontal", PlotMark::kDot, {}, {}}, vertical{"vertical", PlotMark::kRing, {}, {}};
  for (const MatchedPoint& point : result.points) {
    const Vector3d residual_mm = 1e3 * result.fit.Residual(point.common);
    const double distance_m = point.common.rig_b_m.norm();
    horizontal.points.emplace_back(distance_m, residual_mm.head<2>().norm());
    vertical.points.emplace_back(distance_m, std::abs(residual_mm.z()));
  }
  plot.series = {horizontal, vertical};
  return plot;
}

}  // namespace

ReportPage MakeGeorefPage(const Georeferencing& result, const GeorefOrigin& origin) {
  ReportPage page("georef", "The rig in the site grid",
                  "control " + origin.control_file + " (crc32 " + origin.control_crc32 + "), measured " +
                      origin.measured + " until " + origin.time + ", calibration " + origin.calibration_id +
                      ", surveyor " + (origin.surveyor.empty() ? "not told" : origin.surveyor));
  const auto refusal = result.Refusal();
  page.Verdict(refusal ? ReportVerdict::kBad : ReportVerdict::kGood, refusal ? *refusal : "Accepted.");
  page.Facts(
      {{"parameters", "parameters", ReportNumber(result.options.Parameters(), 0), ""},
       {"grid_scale_factor", "grid scale factor (given)", ReportNumber(result.options.grid_scale_factor, 8),
        ""},
       {"sigma0", "sigma0 a posteriori", ReportNumber(result.fit.sigma0, 3), ""},
       {"redundancy", "redundancy", ReportNumber(result.fit.redundancy, 0), ""},
       {"rms_horizontal_mm", "rms horizontal", ReportNumber(1e3 * result.rms_horizontal_m, 1), "mm"},
       {"rms_vertical_mm", "rms vertical", ReportNumber(1e3 * result.rms_vertical_m, 1), "mm"},
       {"rms_mm", "rms 3D", ReportNumber(1e3 * result.rms_m, 1), "mm"},
       {"limit_rms_mm", "rms allowed", ReportNumber(1e3 * result.limits.rms_m, 1), "mm"},
       {"largest_mm", "largest residual", ReportNumber(1e3 * result.largest_m, 1), "mm"},
       {"limit_residual_mm", "largest allowed", ReportNumber(1e3 * result.limits.residual_m, 1), "mm"}});
  if (!origin.unmatched.empty()) page.Paragraph(UnmatchedText(origin.unmatched));
  page.Section("Parameters");
  page.Add(ParameterTable(result));
  page.Section("Points");
  page.Add(PointTable(result));
  page.Add(PlanPlot(result));
  page.Add(HoldOutPlot(result));
  page.Add(DistanceResidualPlot(result));
  return page;
}

}  // namespace adit::host
