#include "host/calibration.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "host/bundle.h"
#include "host/essential.h"
#include "host/pair_consensus.h"

namespace adit::host {
namespace {

using base::Error;
using base::ErrorCode;

// chi2 of a right bar: 16 residuals, 5 parameters of its own. Median and 99.9 % of 11 degrees of freedom.
constexpr double kChi2Median = 10.34, kChi2Max = 31.3;
constexpr double kSigma0Min = 0.1;  // centroids ten times better than promised are exact ones
constexpr int kRejectRounds = 4;
constexpr double kCoverageMinPct = 10;  // 5 of 48 cells: a bar that stays in one place touches fewer
// Beyond these a rig is of no use at any distance: 1 mrad is 0.25 m at 50 m from a 9 m base.
constexpr double kYawSigmaMaxRad = 1e-3, kBaselineSigmaMax = 0.02;

Error Refusal(const CalibrationInput& input, const std::string& detail) {
  return {ErrorCode::kFailed, input.name, detail};
}

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

RayBar Rays(const CalibrationInput& input, const StereoBar& bar) {
  RayBar rays;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    rays[i] = {input.left.Normalised(bar.left[i].ideal_px), input.right.Normalised(bar.right[i].ideal_px)};
  }
  return rays;
}

/// LED 1 to LED 4 as measured, each end triangulated on its own.
double MeasuredLengthM(const CalibrationInput& input, const RelativePose& pose, const StereoBar& bar) {
  const RayBar rays = Rays(input, bar);
  const auto first = Triangulate(pose, rays.front());
  const auto last = Triangulate(pose, rays.back());
  return first && last ? (last->point_l - first->point_l).norm() : std::numeric_limits<double>::quiet_NaN();
}

std::vector<StereoBar> Similar(const CalibrationInput& input, double angle_max_rad) {
  std::vector<StereoBar> bars;
  for (const StereoBar& bar : input.bars) {
    if (LooksSimilar(bar, angle_max_rad)) bars.push_back(bar);
  }
  return bars;
}

/// The relative pose with metres: known bar over its mean measured length (seed eq. 4.1), the mean taken over
/// the middle half, because a wrong pair can be any length.
std::optional<RelativePose> ScaledPose(const CalibrationInput& input, const Consensus& consensus,
                                       const std::vector<StereoBar>& bars) {
  std::vector<RayPair> points;
  for (const std::size_t i : consensus.bars) {
    for (const RayPair& led : Rays(input, bars[i])) points.push_back(led);
  }
  auto pose = ChoosePose(consensus.essential, points);
  if (!pose) return std::nullopt;
  std::vector<double> lengths;  // in units of baseline per metre of bar
  for (const std::size_t i : consensus.bars) {
    const double length = MeasuredLengthM(input, *pose, bars[i]) / input.targets[bars[i].target].LengthM();
    if (std::isfinite(length)) lengths.push_back(length);
  }
  if (lengths.empty()) return std::nullopt;
  std::sort(lengths.begin(), lengths.end());
  const std::size_t from = lengths.size() / 4, to = lengths.size() - from;
  double sum = 0;
  for (std::size_t i = from; i < to; ++i) sum += lengths[i];
  pose->translation_m /= sum / static_cast<double>(to - from);
  return pose;
}

/// Bars that can be placed by `pose`, and their places.
struct Placed {
  std::vector<StereoBar> bars;
  std::vector<BarPlace> places;
};

Placed Place(const CalibrationInput& input, const RelativePose& pose, const std::vector<StereoBar>& bars) {
  Placed placed;
  const BundleInput geometry{input.left, input.right, input.targets, bars};
  for (const StereoBar& bar : bars) {
    if (const auto place = PlaceBar(geometry, pose, bar)) {
      placed.bars.push_back(bar);
      placed.places.push_back(*place);
    }
  }
  return placed;
}

/// sigma0 by the median, which wrong pairs do not move.
double MedianSigma0(const Bundle& bundle) { return std::sqrt(Median(bundle.chi2) / kChi2Median); }

/// Keeps bars within the gate, and of several candidates of one frame and target the best.
Placed KeepRight(const Placed& placed, const Bundle& bundle) {
  const double gate = kChi2Max * std::pow(std::max(kSigma0Min, MedianSigma0(bundle)), 2);
  std::map<std::pair<base::TimeNs, int>, std::size_t> best;
  for (std::size_t i = 0; i < placed.bars.size(); ++i) {
    if (!(bundle.chi2[i] <= gate)) continue;
    const auto [entry, is_new] =
        best.emplace(std::pair<base::TimeNs, int>{placed.bars[i].mid_exposure_ns, placed.bars[i].target}, i);
    if (!is_new && bundle.chi2[i] < bundle.chi2[entry->second]) entry->second = i;
  }
  Placed kept;
  for (const auto& [key, i] : best) {
    kept.bars.push_back(placed.bars[i]);
    kept.places.push_back(bundle.places[i]);
  }
  return kept;
}

struct Fit {
  Placed placed;
  Bundle bundle;
};

/// Robust adjustment, wrong pairs out, again, until none leaves; then least squares over the right pairs.
std::optional<Fit> Refine(const CalibrationInput& input, RelativePose pose, Placed placed,
                          std::size_t bars_min) {
  for (int round = 0; round < kRejectRounds && placed.bars.size() >= bars_min; ++round) {
    const BundleInput geometry{input.left, input.right, input.targets, placed.bars};
    const auto bundle = AdjustBundle(geometry, pose, placed.places, BundleLoss::kRobust);
    if (!bundle) return std::nullopt;
    pose = bundle->T_r_l;
    Placed kept = KeepRight(placed, *bundle);
    const bool settled = kept.bars.size() == placed.bars.size();
    placed = std::move(kept);
    if (settled) break;
  }
  if (placed.bars.size() < bars_min) return Fit{placed, {}};
  const BundleInput geometry{input.left, input.right, input.targets, placed.bars};
  auto bundle = AdjustBundle(geometry, pose, placed.places, BundleLoss::kLeast);
  if (!bundle) return std::nullopt;
  return Fit{std::move(placed), std::move(*bundle)};
}

double CoveragePct(const std::vector<StereoBar>& bars, const optics::CameraModel& camera,
                   BarView StereoBar::*side) {
  constexpr int kColumns = 8, kRows = 6;
  std::array<bool, kColumns * kRows> touched{};
  for (const StereoBar& bar : bars) {
    for (const LedView& led : bar.*side) {
      const int column = static_cast<int>((led.ideal_px.x() + 0.5) / camera.width_px * kColumns);
      const int row = static_cast<int>((led.ideal_px.y() + 0.5) / camera.height_px * kRows);
      touched[static_cast<std::size_t>(std::clamp(row, 0, kRows - 1) * kColumns +
                                       std::clamp(column, 0, kColumns - 1))] = true;
    }
  }
  return 100.0 * static_cast<double>(std::count(touched.begin(), touched.end(), true)) / touched.size();
}

void MeasureBars(const CalibrationInput& input, const Fit& fit, CalibrationQuality& quality) {
  double error_px2 = 0, sum_m = 0, squares_m2 = 0;
  quality.nearest_m = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < fit.placed.bars.size(); ++i) {
    const StereoBar& bar = fit.placed.bars[i];
    const double miss_m = MeasuredLengthM(input, fit.bundle.T_r_l, bar) - input.targets[bar.target].LengthM();
    sum_m += miss_m;
    squares_m2 += miss_m * miss_m;
    error_px2 += fit.bundle.error_px2[i];
    const double distance_m = fit.bundle.places[i].centre_l_m.norm();
    quality.nearest_m = std::min(quality.nearest_m, distance_m);
    quality.farthest_m = std::max(quality.farthest_m, distance_m);
  }
  const auto count = static_cast<double>(fit.placed.bars.size());
  quality.rms_px = std::sqrt(error_px2 / (16 * count));  // 4 LEDs, 2 images, 2 coordinates
  quality.bar_bias_m = sum_m / count;
  quality.bar_rms_m = std::sqrt(squares_m2 / count);
}

Calibration Conclude(const CalibrationInput& input, const Fit& fit) {
  Calibration out;
  out.rig = {input.left, input.right, fit.bundle.T_r_l, ""};
  CalibrationQuality& quality = out.quality;
  quality.bars_used = fit.placed.bars.size();
  double chi2 = 0;
  for (const double bar_chi2 : fit.bundle.chi2) chi2 += bar_chi2;
  quality.sigma0 = std::sqrt(chi2 / (11.0 * static_cast<double>(quality.bars_used) - 6.0));
  out.covariance = *fit.bundle.covariance * std::max(1.0, quality.sigma0 * quality.sigma0);
  MeasureBars(input, fit, quality);
  const Eigen::Vector3d t = fit.bundle.T_r_l.translation_m;
  quality.baseline_m = t.norm();
  quality.baseline_sigma_m =
      std::sqrt(t.normalized().dot(out.covariance.bottomRightCorner<3, 3>() * t.normalized()));
  quality.sigma_rad = out.covariance.diagonal().head<3>().cwiseSqrt();
  quality.coverage_left_pct = CoveragePct(fit.placed.bars, input.left, &StereoBar::left);
  quality.coverage_right_pct = CoveragePct(fit.placed.bars, input.right, &StereoBar::right);
  for (const StereoBar& bar : fit.placed.bars)
    out.newest_bar_ns = std::max(out.newest_bar_ns, bar.mid_exposure_ns);
  return out;
}

std::string TooFew(std::size_t found, std::size_t wanted, const std::string& what) {
  return std::to_string(found) + " " + what + "; at least " + std::to_string(wanted) +
         " are needed: wave the bar longer, in view of both cameras";
}

/// Why the bars cannot hold a pose before any is sought; empty if they may.
std::string Concentrated(const CalibrationInput& input, const std::vector<StereoBar>& bars) {
  const double left_pct = CoveragePct(bars, input.left, &StereoBar::left);
  const double right_pct = CoveragePct(bars, input.right, &StereoBar::right);
  const bool is_left = left_pct < right_pct;
  const double least_pct = std::min(left_pct, right_pct);
  if (least_pct >= kCoverageMinPct) return "";
  return "the bars touch " + std::to_string(std::lround(least_pct)) + " % of " + (is_left ? "cam0" : "cam1") +
         "'s image; at least 10 % are needed: wave the bar through the whole of both images, near and far";
}

base::Result<Calibration> Judged(const CalibrationInput& input, Calibration calibration) {
  const CalibrationQuality& q = calibration.quality;
  if (!(q.sigma_rad.y() < kYawSigmaMaxRad) || !(q.baseline_sigma_m < kBaselineSigmaMax * q.baseline_m)) {
    return Refusal(input, "the bars are too concentrated to hold the relative pose: yaw stays uncertain by " +
                              std::to_string(q.sigma_rad.y() * 1e3) + " mrad (at most 1), the baseline by " +
                              std::to_string(q.baseline_sigma_m) +
                              " m (at most 2 %); wave the bar through "
                              "the whole of both images, near and far");
  }
  const double right_x_m = calibration.rig.T_r_l.Inverse().translation_m.x();
  if (!(right_x_m > 0)) {
    return Refusal(input, "finds cam1 at x = " + std::to_string(right_x_m) +
                              " m, left of cam0; exchange the cameras: cam0 must be the left one");
  }
  return calibration;
}

}  // namespace

base::Result<Calibration> Calibrate(const CalibrationInput& input, const CalibrationOptions& options) {
  if (input.bars.empty()) {
    return Refusal(input, TooFew(0, options.bars_min, "bars identified in both images"));
  }
  std::map<std::pair<base::TimeNs, int>, int> seen;
  for (const StereoBar& bar : input.bars) ++seen[{bar.mid_exposure_ns, bar.target}];
  if (seen.size() < options.bars_min) {
    return Refusal(input, TooFew(seen.size(), options.bars_min, "bars identified in both images"));
  }
  const std::vector<StereoBar> similar = Similar(input, options.similarity_max_rad);
  if (similar.size() < options.bars_min) {
    return Refusal(input,
                   TooFew(similar.size(), options.bars_min,
                          "bars have a similar direction in both images (a mirrored or turned image?)"));
  }
  if (const std::string reason = Concentrated(input, similar); !reason.empty()) return Refusal(input, reason);
  std::vector<RayBar> rays;
  for (const StereoBar& bar : similar) rays.push_back(Rays(input, bar));
  const double focal_px =
      0.25 * (input.left.fu_px + input.left.fv_px + input.right.fu_px + input.right.fv_px);
  const auto consensus = FindConsensus(rays, focal_px, {});
  if (!consensus || consensus->bars.size() < options.bars_min) {
    return Refusal(input, TooFew(consensus ? consensus->bars.size() : 0, options.bars_min,
                                 "bars agree on one epipolar geometry"));
  }
  const auto start = ScaledPose(input, *consensus, similar);
  if (!start)
    return Refusal(input, "no relative pose has the bars in front of both cameras; is one image mirrored?");
  std::vector<StereoBar> agreed;
  for (const std::size_t i : consensus->bars) agreed.push_back(similar[i]);
  const auto fit = Refine(input, *start, Place(input, *start, agreed), options.bars_min);
  if (!fit)
    return Refusal(input,
                   "the bundle adjustment does not converge: do the camera files belong to these cameras, "
                   "the models to these bars?");
  if (fit->placed.bars.size() < options.bars_min) {
    return Refusal(input, TooFew(fit->placed.bars.size(), options.bars_min, "bars fit one relative pose"));
  }
  if (!fit->bundle.covariance) {
    return Refusal(input, "the bars leave the relative pose undetermined; move the bar through the volume");
  }
  Calibration calibration = Conclude(input, *fit);
  calibration.quality.bars_seen = seen.size();
  return Judged(input, std::move(calibration));
}

}  // namespace adit::host
