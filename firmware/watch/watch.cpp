#include "firmware/watch/watch.h"

#include <algorithm>
#include <cmath>

#include "firmware/base/symmetric.h"

namespace adit::watch {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

/// The phase bias of a centroid has the period of the pixels.
constexpr double kPlacePx = 1;
/// 11 degrees of freedom less what the motion takes: noise of twice what is stated passes, a wrong match of a
/// pixel does not.
constexpr double kViewChiSquareMax = 100;
/// What a turn may be, far beyond what the stereo stage still follows.
constexpr double kTurnRad = 1e-3;
/// Of its length, to which a bar is known (bounds: 0.1 mm in 0.82 m).
constexpr double kBarScale = 1.2e-4;
/// Fewer residuals than this say nothing of their own spread.
constexpr int kRedundancyMin = 200;

/// The covariance of (rotation, translation of T_r_l) as one of Motion: the centre is -R^T t.
MotionMatrix AsMotion(const optics::Rig& rig, const MotionMatrix& covariance) {
  const Matrix3d back = -rig.T_r_l.rotation.transpose();
  MotionMatrix map = MotionMatrix::Identity();
  map.bottomLeftCorner<3, 3>() = back * base::Skew(rig.T_r_l.translation_m);
  map.bottomRightCorner<3, 3>() = back;
  return base::Congruence(map, covariance);
}

/// Variance of the residuals that the motion leaves, in units of what they state.
double Spread(const Information& bars, const Motion& x) {
  if (bars.redundancy < kRedundancyMin) return 1;
  return (bars.chi_square - 2 * x.dot(bars.gradient) + x.dot(bars.normal * x)) / bars.redundancy;
}

}  // namespace

Watch::Watch(const optics::Rig& rig, const std::vector<base::Target>& targets, const WatchOptions& options,
             const MotionMatrix& calibration_covariance)
    : views_(stereo::MakeViews(rig)),
      targets_(targets),
      options_(options),
      lanes_(targets.size()),
      lights_(views_, options.lights_b_m) {
  prior_covariance_ = AsMotion(rig, calibration_covariance);
  // A bar too long by a part looks like a baseline too short by it, and like a rig that has shifted since.
  const Vector3d scale_m = kBarScale * rig.T_r_l.Inverse().translation_m;
  prior_covariance_.bottomRightCorner<3, 3>() += scale_m * scale_m.transpose();
  prior_covariance_.diagonal().tail<3>().array() += std::pow(options.shift_sigma_m, 2);
  prior_covariance_.diagonal().head<3>().array() += std::pow(options.allowance_rad, 2);
  prior_ = base::InverseSymmetric(prior_covariance_);
  change_prior_.setZero();
  change_prior_.diagonal().head<3>().setConstant(1 / (kTurnRad * kTurnRad));
  change_prior_.diagonal().tail<3>().setConstant(1 / std::pow(options.shift_sigma_m, 2));
  for (Lane& lane : lanes_) {
    lane.reference.by_prior.setIdentity();
    lane.reference.by_noise.setZero();
  }
}

void Watch::Add(const stereo::PointSet& set) {
  constexpr int kLights = 3;  // fewer tell nothing
  bool any = lights_.Add(*set.left->blob_set, *set.right->blob_set) >= kLights;
  for (std::size_t i = 0; i < std::min(set.targets.size(), lanes_.size()); ++i) {
    const stereo::TargetPoints& points = set.targets[i];
    any = (points.status == stereo::FixStatus::kTracked && Look(i, set, points)) || any;
  }
  if (!any) return;
  second_pairs_ += 1;
  finding_.tracked_s += 1 / options_.rate_hz;
  if (second_pairs_ >= options_.rate_hz) EndSecond();
}

bool Watch::Look(std::size_t target, const stereo::PointSet& set, const stereo::TargetPoints& points) {
  Lane& lane = lanes_[target];
  if (lane.view.MoveTo(set, points) >= kPlacePx) {
    Close(target, false);
  } else if (lane.view.Pairs() >= options_.rate_hz) {
    Close(target, true);
  }
  if (!lane.view.Add(views_, targets_[target], set, points)) return false;
  lane.learning_pairs += 1;
  return true;
}

void Watch::Close(std::size_t target, bool stayed) {
  Lane& lane = lanes_[target];
  // A bar that stays at its place shows the same bias in every view: all of these together may say no more
  // than one.
  const double bias_px = options_.bias_px * (stayed ? std::sqrt(options_.learn_s) : 1);
  const auto information = lane.view.Read(views_, targets_[target], bias_px, kViewChiSquareMax);
  lane.view.Clear();
  if (!information) {
    finding_.wrong += 1;
    return;
  }
  lane.window[slot_] += *information;
  lane.learning += *information;
}

void Watch::EndSecond() {
  second_pairs_ = 0;
  EndSecondOfLights();
  Test();
  slot_ = (slot_ + 1) % kWindowS;
  lights_window_[slot_] = {};
  for (Lane& lane : lanes_) {
    if (finding_.verdict == Verdict::kChanged) {
      lane.learning = {};
      lane.learning_pairs = 0;
    } else if (!lane.reference.learned && lane.learning_pairs >= options_.learn_s * options_.rate_hz) {
      Learn(lane);
    }
    lane.window[slot_] = {};
  }
}

void Watch::EndSecondOfLights() {
  const auto information = lights_.EndSecond(kWindowS, finding_.wrong);
  if (information) lights_window_[slot_] = *information;
  if (finding_.verdict == Verdict::kChanged) {
    lights_.Forget();
    lights_learned_s_ = 0;
  } else if (++lights_learned_s_ == options_.learn_s) {
    lights_.Learn(options_.learn_s);
    lights_.Forget();
    lights_learned_s_ = 0;
  }
}

void Watch::Learn(Lane& lane) const {
  const MotionMatrix covariance = base::InverseSymmetric(MotionMatrix(prior_ + lane.learning.normal));
  lane.reference.motion = covariance * lane.learning.gradient;
  lane.reference.by_prior = covariance * prior_;
  lane.reference.by_noise = covariance * lane.learning.normal * covariance;
  lane.reference.learned = true;
  lane.window.fill({});  // it made the reference, and cannot be tested against it
}

void Watch::Test() {
  // With A the normal matrices of the targets, x their references: the change d solves
  // (sum A + prior) d = sum (g - A x). The errors of the x come from the calibration's one error, the same in
  // all of them, and from the noise of each one's learning.
  Information lights, bars;
  for (const Information& second : lights_window_) lights += second;
  const bool lit = !lights.normal.isZero(0);
  MotionMatrix by_calibration = MotionMatrix::Zero(), noise = MotionMatrix::Zero();
  for (const Lane& lane : lanes_) {
    // Beside lights that know of a microradian, a bar measured against the calibration only disturbs.
    if (lit && !lane.reference.learned) continue;
    Information window;
    for (const Information& second : lane.window) window += second;
    const Motion& x = lane.reference.motion;
    const Motion predicted = window.normal * x;
    window.chi_square += x.dot(predicted) - 2 * x.dot(window.gradient);
    window.gradient -= predicted;
    bars += window;
    by_calibration += window.normal * lane.reference.by_prior;
    noise += window.normal * lane.reference.by_noise * window.normal;
  }
  if (bars.redundancy < kRedundancyMin && !lit) return;
  const MotionMatrix gain = base::InverseSymmetric(MotionMatrix(bars.normal + lights.normal + change_prior_));
  const Motion change = gain * (bars.gradient + lights.gradient);
  noise = std::max(1.0, Spread(bars, change)) * (noise + bars.normal);
  noise += lights.normal + change_prior_ + base::Congruence(by_calibration, prior_covariance_);
  Matrix3d covariance = (gain * noise * gain).topLeftCorner<3, 3>();
  covariance.diagonal().array() += std::pow(options_.allowance_rad, 2);
  Judge(change.head<3>(), covariance);
}

void Watch::Judge(const Vector3d& turn_rad, const Matrix3d& covariance) {
  const double significance = (turn_rad.array().abs() / covariance.diagonal().array().sqrt()).maxCoeff();
  if (!std::isfinite(significance)) return;
  finding_.significance = significance;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    finding_.turn_rad[i] = turn_rad[axis];
    finding_.sigma_rad[i] = std::sqrt(covariance(axis, axis));
  }
  // An alarm that traffic without evidence would end is worth nothing.
  constexpr double kAsMuchEvidence = 1.5;
  if (significance > kAlarm) {
    if (finding_.verdict != Verdict::kChanged) alarm_sigma_rad_ = finding_.sigma_rad[1];
    finding_.verdict = Verdict::kChanged;
  } else if (finding_.verdict == Verdict::kChanged) {
    const bool evident = finding_.sigma_rad[1] <= kAsMuchEvidence * alarm_sigma_rad_;
    if (!(evident && significance < kClear)) return;
    finding_.verdict = Verdict::kLearning;
  }
  if (finding_.verdict != Verdict::kLearning) return;
  const auto learned = [](const Lane& lane) { return lane.reference.learned; };
  if (lights_.Learned() || std::any_of(lanes_.begin(), lanes_.end(), learned))
    finding_.verdict = Verdict::kHolds;
}

}  // namespace adit::watch
