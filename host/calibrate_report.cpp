#include "host/calibrate_report.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "firmware/stereo/bar_fit.h"
#include "firmware/stereo/triangulate.h"
#include "host/calibration_tables.h"

namespace adit::host {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kWrongChi2 = 31.3;  // 99.9 % of 11 degrees of freedom
constexpr int kBarColumns = 8, kBarRows = 6;
constexpr std::size_t kBarVectorsMax = 1200;

/// One candidate by the finished rig.
struct SeenBar {
  const StereoBar* bar = nullptr;
  double distance_m = 0;
  Vector3d centre_b_m = Vector3d::Zero();
  double length_error_m = 0, length_sigma_m = 0;
  stereo::BarResiduals residuals_px = stereo::BarResiduals::Zero();  ///< seen minus measured
};

double ChiSquareOf(const stereo::BarObservations& observations, const stereo::BarResiduals& residuals_px) {
  double chi2 = 0;
  for (std::size_t i = 0; i < 2 * base::kLedCount; ++i) {
    const Vector2d residual_px = residuals_px.segment<2>(static_cast<Eigen::Index>(2 * i));
    chi2 += (observations[i / 2][i % 2].Whitener(0) * residual_px).squaredNorm();
  }
  return chi2;
}

/// None for wrong pairs.
std::optional<SeenBar> Look(const stereo::Views& views, const base::Target& target, const StereoBar& bar) {
  stereo::BarObservations observations;
  std::array<Vector3d, base::kLedCount> leds_m = base::ZeroPoints<base::kLedCount>();
  std::array<Eigen::Matrix3d, base::kLedCount> covariances;
  for (std::size_t i = 0; i < leds_m.size(); ++i) {
    observations[i][0] = {bar.left[i].ideal_px, bar.left[i].covariance_px2};
    observations[i][1] = {bar.right[i].ideal_px, bar.right[i].covariance_px2};
    const auto led = stereo::Triangulate(views, observations[i]);
    if (!led) return std::nullopt;
    leds_m[i] = led->point_b_m, covariances[i] = led->covariance_m2;
  }
  const auto fit = stereo::FitBar(views, target, observations, leds_m);
  if (!fit || !(ChiSquareOf(observations, fit->residuals_px) <= kWrongChi2)) return std::nullopt;
  SeenBar seen;
  seen.bar = &bar;
  seen.centre_b_m = fit->bar.centre_b_m;
  seen.distance_m = seen.centre_b_m.norm();
  const Vector3d span_m = leds_m.back() - leds_m.front(), along = span_m.normalized();
  seen.length_error_m = span_m.norm() - target.LengthM();
  seen.length_sigma_m = std::sqrt(along.dot((covariances.front() + covariances.back()) * along));
  seen.residuals_px = fit->residuals_px;
  return seen;
}

void FrameCamera(const optics::CameraModel& camera, Plot& plot) {
  plot.same_scale = true;
  plot.x.label = "u, px", plot.y.label = "v, px";
  plot.x.range = {0, camera.width_px}, plot.y.range = {0, camera.height_px};
  plot.y.reversed = true;
}

Plot BarCoverage(const std::vector<SeenBar>& bars, const optics::CameraModel& camera,
                 BarView StereoBar::*side, const std::string& name) {
  Plot plot;
  plot.title = "LEDs in the image of " + name;
  plot.note = "Counts in 8 x 6 cells, undistorted; hatched: none.";
  FrameCamera(camera, plot);
  PlotCells cells{"LEDs",   kBarColumns,
                  kBarRows, std::vector<double>(kBarColumns * kBarRows, 0),
                  {0, 0},   {camera.width_px, camera.height_px}};
  for (const SeenBar& seen : bars) {
    for (const LedView& led : seen.bar->*side) {
      const int column =
          std::clamp(static_cast<int>(led.ideal_px.x() / camera.width_px * kBarColumns), 0, kBarColumns - 1);
      const int row =
          std::clamp(static_cast<int>(led.ideal_px.y() / camera.height_px * kBarRows), 0, kBarRows - 1);
      ++cells.values[static_cast<std::size_t>(row * kBarColumns + column)];
    }
  }
  plot.cells.push_back(std::move(cells));
  return plot;
}

Plot BarResidualPlot(const std::vector<SeenBar>& bars, const optics::CameraModel& camera, std::size_t side,
                     const std::string& name) {
  Plot plot;
  plot.title = "Residuals in " + name;
  plot.note =
      "Of rigid bars. A common direction in one region is a lens that the camera file does not describe.";
  FrameCamera(camera, plot);
  PlotVectors vectors{"residual", "px", 1, {}, {}};
  const std::size_t stride = 1 + bars.size() * base::kLedCount / kBarVectorsMax;
  for (std::size_t i = 0; i < bars.size() * base::kLedCount; i += stride) {
    const SeenBar& seen = bars[i / base::kLedCount];
    const std::size_t led = i % base::kLedCount;
    vectors.places.push_back((side == 0 ? seen.bar->left : seen.bar->right)[led].ideal_px);
    vectors.steps.push_back(seen.residuals_px.segment<2>(static_cast<Eigen::Index>(4 * led + 2 * side)));
  }
  vectors.magnified = RoundMagnification(vectors.steps, camera.width_px);
  plot.vectors.push_back(std::move(vectors));
  return plot;
}

Plot LengthPlot(const std::vector<SeenBar>& bars) {
  Plot plot;
  plot.title = "Bar length against distance";
  plot.note = "Measured minus true, LEDs each on their own; 95 % must lie between the rings.";
  plot.x.label = "distance, m", plot.y.label = "error of the bar length, mm";
  PlotSeries error{"error", PlotMark::kDot, {}, {}}, stated{"two stated sigmas", PlotMark::kRing, {}, {}};
  const std::size_t stride = 1 + bars.size() / kBarVectorsMax;
  for (std::size_t i = 0; i < bars.size(); i += stride) {
    error.points.emplace_back(bars[i].distance_m, 1e3 * bars[i].length_error_m);
    for (const double side : {-2e3, 2e3})
      stated.points.emplace_back(bars[i].distance_m, side * bars[i].length_sigma_m);
  }
  plot.series = {error, stated};
  return plot;
}

Plot BarsFromAbove(const std::vector<SeenBar>& bars, const optics::Rig& rig) {
  Plot plot;
  plot.title = "From above";
  plot.note = "Frame of the left camera, z its axis.";
  plot.same_scale = true;
  plot.x.label = "x, m", plot.y.label = "z, m";
  PlotSeries places{"bars", PlotMark::kDot, {}, {}};
  for (const SeenBar& seen : bars) places.points.emplace_back(seen.centre_b_m.x(), seen.centre_b_m.z());
  const Vector3d right_m = rig.T_r_l.Inverse().translation_m;
  plot.series = {places, {"cameras", PlotMark::kCross, {{0, 0}, {right_m.x(), right_m.z()}}, {}}};
  return plot;
}

Plot HoldOutPlot(const HoldOut& held) {
  Plot plot;
  plot.title = "Held-out bars against their prediction";
  plot.note =
      "Bars that the adjustment never saw; 95 % must lie between the lines at twice what is predicted.";
  plot.x.label = "predicted, 1 sigma, mm", plot.y.label = "error of the bar length, mm";
  PlotSeries errors{"error", PlotMark::kDot, {}, {}};
  double widest_mm = 0;
  for (const HeldBar& bar : held.bars) {
    errors.points.emplace_back(1e3 * bar.predicted_m, 1e3 * bar.error_m);
    widest_mm = std::max(widest_mm, 1e3 * bar.predicted_m);
  }
  plot.series = {errors,
                 {"two sigmas", PlotMark::kDashedLine, {{0, 0}, {widest_mm, 2 * widest_mm}}, {}},
                 {"", PlotMark::kDashedLine, {{0, 0}, {widest_mm, -2 * widest_mm}}, {}}};
  return plot;
}

std::string Joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

/// Of the lenses and what they lead to.
void AddFigures(const CalibrationInput& input, const Calibration& calibration, ReportPage& page) {
  page.Section("Lenses");
  ReportTable intrinsics = IntrinsicTable(input, calibration);
  if (intrinsics.rows.empty()) {
    page.Paragraph("Taken as in their files.");
  } else {
    page.Paragraph("Refined in the adjustment, within what their files may be wrong by.");
    page.Add(std::move(intrinsics));
  }
  page.Section("What to expect");
  page.Add(PredictionTable(calibration.quality));
}

}  // namespace

ReportPage MakeCalibrateReport(const CalibrationInput& input, const Calibration& calibration) {
  const optics::Rig& rig = calibration.rig;
  const stereo::Views views = stereo::MakeViews(rig);
  std::vector<SeenBar> bars;
  double inside = 0;
  for (const StereoBar& bar : calibration.bars) {
    if (const auto seen = Look(views, input.targets[bar.target], bar)) bars.push_back(*seen);
  }
  for (const SeenBar& seen : bars) inside += std::abs(seen.length_error_m) <= 2 * seen.length_sigma_m ? 1 : 0;
  ReportPage page("calibrate", "Relative pose of two cameras", Joined(input.recordings));
  const bool good = calibration.verdict == Verdict::kGood;
  page.Verdict(good ? ReportVerdict::kGood : ReportVerdict::kCaution,
               good ? "Accepted." : "Usable, but:", calibration.reservations);
  std::vector<ReportFact> facts = QualityFacts(calibration);
  const double inside_pct = bars.empty() ? std::nan("") : 100 * inside / static_cast<double>(bars.size());
  facts.push_back({"within_two_sigma_pct", "lengths within 2 sigmas", ReportNumber(inside_pct, 1), "%"});
  page.Facts(std::move(facts));
  AddFigures(input, calibration, page);
  page.Section("Coverage");
  page.Add(BarCoverage(bars, rig.left, &StereoBar::left, "cam0"));
  page.Add(BarCoverage(bars, rig.right, &StereoBar::right, "cam1"));
  page.Add(BarsFromAbove(bars, rig));
  if (!calibration.quality.gaps.empty()) page.Add(GapTable(calibration.quality.gaps));
  page.Section("Fit");
  page.Add(BarResidualPlot(bars, rig.left, 0, "cam0"));
  page.Add(BarResidualPlot(bars, rig.right, 1, "cam1"));
  page.Add(LengthPlot(bars));
  if (!calibration.quality.hold_out.bars.empty()) page.Add(HoldOutPlot(calibration.quality.hold_out));
  if (!calibration.wrong.empty()) page.Add(WrongPairTable(input, calibration.wrong));
  return page;
}

}  // namespace adit::host
