#include "host/calibration_verdict.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "host/bundle_covariance.h"

namespace adit::host {
namespace {

// Beyond these a rig is of no use at any distance: 1 mrad is 0.25 m at 50 m from a 9 m base.
constexpr double kYawSigmaMaxRad = 1e-3, kBaselineSigmaMax = 0.02;
constexpr double kPullMax = 5, kPullDoubtful = 2.5;  // rms over the parameters, in prior sigmas
// Beyond chance by this factor the data contradict the calibration; a covariance of the centroids that is a
// model may be off by less.
constexpr double kHoldOutMax = 1.5;
constexpr double kSigma0Doubtful = 1.5;
constexpr double kCoverageGoodPct = 50;
constexpr double kReachGood =
    0.6;  // bars that end nearer than this share of a distance leave it to extrapolation
constexpr std::array<double, 3> kDistancesM{30, 70, 110};
constexpr double kBarResidualsFree = 11;  // 16 residuals, 5 parameters

std::string Fixed(double value, int digits) {
  std::string text = std::to_string(value);
  const auto point = text.find('.');
  return text.substr(0, point + (digits > 0 ? 1 + static_cast<std::size_t>(digits) : 0));
}

/// How far the intrinsics moved from their files: rms in prior sigmas over the directions that may move.
double Pull(const CalibrationInput& input, const optics::Rig& rig) {
  double squares = 0, count = 0;
  const auto add = [&](const IntrinsicPrior& prior, const optics::CameraModel& was,
                       const optics::CameraModel& is) {
    squares += prior.Steps(Intrinsics(was), Intrinsics(is)).squaredNorm();
    for (const auto& column : prior.root.colwise()) count += column.isZero(0) ? 0 : 1;
  };
  add(input.left_prior, input.left, rig.left);
  add(input.right_prior, input.right, rig.right);
  return count > 0 ? std::sqrt(squares / count) : 0;
}

/// The setting of the hold-out test: bars of their adjusted length, which then is exact.
BundleSetting AsAdjusted(const CalibrationFit& fit) {
  BundleSetting setting = fit.setting;
  for (std::size_t i = 0; i < setting.targets.size(); ++i) {
    for (double& place_m : setting.targets[i].leds_m) place_m *= fit.bundle.state.length_scale[i];
  }
  setting.bar_sigma_m = 0;
  return setting;
}

void MeasureBars(const CalibrationFit& fit, Calibration& out) {
  CalibrationQuality& q = out.quality;
  double error_px2 = 0, chi2 = 0, sum_m = 0, squares_m2 = 0;
  q.nearest_m = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < fit.bars.size(); ++i) {
    const StereoBar bar = Undistorted(fit.bars[i], out.rig).value_or(fit.bars[i]);
    const auto end = [&](std::size_t led) {
      return Locate(out.rig, {bar.left[led].raw_px, bar.right[led].raw_px}).value_or(Eigen::Vector3d::Zero());
    };
    const base::Target& target = fit.setting.targets[bar.target];
    const double miss_m = (end(base::kLedCount - 1) - end(0)).norm() -
                          target.LengthM() * fit.bundle.state.length_scale[bar.target];
    sum_m += miss_m, squares_m2 += miss_m * miss_m;
    error_px2 += fit.bundle.error_px2[i];
    chi2 += fit.bundle.chi2[i];
    out.distances_m.push_back(fit.bundle.state.places[i].centre_l_m.norm());
    q.nearest_m = std::min(q.nearest_m, out.distances_m.back());
    q.farthest_m = std::max(q.farthest_m, out.distances_m.back());
    out.newest_bar_ns = std::max(out.newest_bar_ns, bar.mid_exposure_ns);
    out.bars.push_back(bar);
  }
  const auto count = static_cast<double>(fit.bars.size());
  q.rms_px = std::sqrt(error_px2 / (16 * count));  // 4 LEDs, 2 images, 2 coordinates
  const double free = kBarResidualsFree * count - 6;
  q.sigma0 = fit.setting.noise_scale * std::sqrt(chi2 / free);
  q.bar_bias_m = sum_m / count;
  q.bar_rms_m = std::sqrt(squares_m2 / count);
}

/// One standard deviation of a centroid's coordinate, as the bars have it in the mean.
double NoisePx(const Calibration& calibration) {
  double variance = 0, count = 0;
  for (const StereoBar& bar : calibration.bars) {
    for (const BarView* view : {&bar.left, &bar.right}) {
      for (const LedView& led : *view) variance += led.covariance_px2.trace() / 2, ++count;
    }
  }
  return std::max(1.0, calibration.quality.sigma0) * std::sqrt(variance / count);
}

}  // namespace

double CoveragePct(std::span<const StereoBar> bars, const optics::CameraModel& camera,
                   BarView StereoBar::*side) {
  constexpr int kColumns = 8, kRows = 6;
  std::array<bool, kColumns * kRows> touched{};
  for (const StereoBar& bar : bars) {
    for (const LedView& led : bar.*side) {
      const int column = static_cast<int>((led.raw_px.x() + 0.5) / camera.width_px * kColumns);
      const int row = static_cast<int>((led.raw_px.y() + 0.5) / camera.height_px * kRows);
      touched[static_cast<std::size_t>(std::clamp(row, 0, kRows - 1) * kColumns +
                                       std::clamp(column, 0, kColumns - 1))] = true;
    }
  }
  return 100.0 * static_cast<double>(std::count(touched.begin(), touched.end(), true)) / touched.size();
}

Calibration Conclude(const CalibrationInput& input, const CalibrationFit& fit,
                     std::span<const StereoBar> held_out) {
  Calibration out;
  out.rig = {fit.bundle.state.left, fit.bundle.state.right, fit.bundle.state.T_r_l, ""};
  out.covariance = *fit.bundle.covariance;
  CalibrationQuality& q = out.quality;
  q.bars_used = fit.bars.size();
  q.points_used = fit.points.size();
  MeasureBars(fit, out);
  const Eigen::Vector3d t = out.rig.T_r_l.translation_m;
  q.baseline_m = t.norm();
  q.baseline_sigma_m = std::sqrt(t.normalized().dot(out.covariance.block<3, 3>(3, 3) * t.normalized()));
  q.sigma_rad = out.covariance.diagonal().head<3>().cwiseSqrt();
  q.coverage_left_pct = CoveragePct(fit.bars, input.left, &StereoBar::left);
  q.coverage_right_pct = CoveragePct(fit.bars, input.right, &StereoBar::right);
  q.intrinsics_pull = Pull(input, out.rig);
  const BundleSetting adjusted = AsAdjusted(fit);
  const auto relative = BundleCovariance(adjusted, {fit.bars, fit.points}, fit.bundle.state);
  q.hold_out = TestHoldOut(adjusted, out.rig, relative.value_or(out.covariance), held_out);
  const double noise_px = NoisePx(out);
  for (const double distance_m : kDistancesM) {
    if (const auto prediction = Predict(out.rig, out.covariance, distance_m, noise_px))
      q.predictions.push_back(*prediction);
  }
  q.gaps = CoverageGaps(out.rig, out.covariance, {out.bars, out.distances_m}, noise_px);
  return out;
}

std::string Refuses(const Calibration& calibration) {
  const CalibrationQuality& q = calibration.quality;
  if (!(q.sigma_rad.y() < kYawSigmaMaxRad) || !(q.baseline_sigma_m < kBaselineSigmaMax * q.baseline_m)) {
    return "the bars are too concentrated to hold the relative pose: yaw stays uncertain by " +
           std::to_string(q.sigma_rad.y() * 1e3) + " mrad (at most 1), the baseline by " +
           std::to_string(q.baseline_sigma_m) +
           " m (at most 2 %); wave the bar through the whole of both images, near and far";
  }
  const double right_x_m = calibration.rig.T_r_l.Inverse().translation_m.x();
  if (!(right_x_m > 0)) {
    return "finds cam1 at x = " + std::to_string(right_x_m) +
           " m, left of cam0; exchange the cameras: cam0 must be the left one";
  }
  if (q.intrinsics_pull > kPullMax) {
    return "the intrinsics move by " + Fixed(q.intrinsics_pull, 1) +
           " of their standard deviations (at most 5): do the camera files belong to these cameras, the "
           "models "
           "to these bars? Else state what they may be wrong by (--focal-sigma-pct, --centre-sigma-px, "
           "--distortion-sigma-px)";
  }
  if (q.hold_out.ratio > kHoldOutMax * q.hold_out.RatioMax()) {
    return "bars that the adjustment did not see miss their length by " + Fixed(q.hold_out.error_m * 1e3, 2) +
           " mm rms, " + Fixed(q.hold_out.predicted_m * 1e3, 2) +
           " mm are predicted: are the models those of the bars, and did the rig stand still?";
  }
  return "";
}

std::vector<std::string> Reservations(const Calibration& calibration) {
  const CalibrationQuality& q = calibration.quality;
  std::vector<std::string> out;
  if (q.sigma0 > kSigma0Doubtful) {
    out.push_back("the centroids are " + Fixed(q.sigma0, 1) +
                  " times worse than they promise: did the bar move fast, or the rig?");
  }
  if (q.intrinsics_pull > kPullDoubtful) {
    out.push_back("the intrinsics moved by " + Fixed(q.intrinsics_pull, 1) +
                  " of their standard deviations: calibrate the cameras again with adit intrinsics");
  }
  if (q.hold_out.ratio > q.hold_out.RatioMax()) {
    out.push_back("held-out bars miss their length by " + Fixed(q.hold_out.ratio, 1) +
                  " times what is predicted");
  }
  if (std::min(q.coverage_left_pct, q.coverage_right_pct) < kCoverageGoodPct) {
    out.push_back("the bars touch " + Fixed(std::min(q.coverage_left_pct, q.coverage_right_pct), 0) +
                  " % of an image, 50 % are good: wave the bar where the coverage map has gaps" +
                  (q.gaps.empty() ? "" : ", next at the " + q.gaps.front().Words()));
  }
  for (const RigPrediction& prediction : q.predictions) {
    if (q.farthest_m < kReachGood * prediction.distance_m && prediction.depth_m > prediction.noise_depth_m) {
      out.push_back("no bar beyond " + Fixed(q.farthest_m, 0) + " m: at " + Fixed(prediction.distance_m, 0) +
                    " m the calibration leaves " + Fixed(prediction.depth_m * 1e3, 0) +
                    " mm of depth; wave the bar farther away too");
      break;
    }
  }
  return out;
}

}  // namespace adit::host
