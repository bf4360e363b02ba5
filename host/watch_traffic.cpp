#include "host/watch_traffic.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "firmware/base/require.h"
#include "host/tunnel.h"

namespace adit::host {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kFullTurnRad = 2 * std::numbers::pi;
constexpr std::uint64_t kTrafficStream = 0x74726166666963;
constexpr double kBaseM = 9;
// From the near end to the far one and back: 60 m each way at 1 to 3 m/s.
constexpr double kPeriodMinS = 40, kPeriodMaxS = 120;

optics::Rig PlainRig() {
  optics::Rig rig = TunnelRig(kBaseM);
  for (optics::CameraModel* camera : {&rig.left, &rig.right})
    camera->k1 = camera->k2 = camera->p1 = camera->p2 = 0;
  return rig;
}

pipeline::Pipeline ReadyPipeline(const optics::Rig& rig) {
  const auto targets = WatchTraffic::Targets();
  auto pipeline = pipeline::Pipeline::Make(rig, ModelsOf({targets.begin(), targets.end()}), {});
  ADIT_REQUIRE(pipeline);
  return std::move(*pipeline);
}

}  // namespace

WatchTraffic::WatchTraffic(const TrafficPlan& plan, std::uint64_t seed)
    : plan_(plan),
      calibrated_(PlainRig()),
      real_(calibrated_),
      frame_(calibrated_),
      draw_(seed, kTrafficStream),
      pipeline_(ReadyPipeline(calibrated_)),
      blobs_(std::make_unique<std::array<detect::BlobSet, 2>>()),
      result_(std::make_unique<pipeline::PairResult>()) {
  for (std::size_t machine = 0; machine < courses_.size(); ++machine) {
    Course& course = courses_[machine];
    course.period_s = draw_.Uniform(kPeriodMinS, kPeriodMaxS);
    course.phase_rad = draw_.Uniform(0, kFullTurnRad);
    // Each keeps to its own side; both cameras see all of it at 20 m.
    course.aside_m = (machine == 0 ? -1 : 1) * draw_.Uniform(0.5, 0.8);
    course.sway_m = draw_.Uniform(0.1, 0.3), course.sway_s = draw_.Uniform(5, 15);
    course.height_m = draw_.Uniform(-0.5, 0.5), course.tilt_rad = draw_.Uniform(-0.4, 0.4);
    length_scale_[machine] = 1 + plan.bar_sigma_m * draw_.Normal() / Targets()[machine].LengthM();
    course.swing_rad = draw_.Uniform(0.1, 0.5), course.swing_s = draw_.Uniform(8, 30);
  }
}

std::array<base::Target, 2> WatchTraffic::Targets() {
  const auto targets = TunnelTargets();
  return {targets[0], targets[1]};
}

void WatchTraffic::Move(const Vector3d& turn_rad, const Vector3d& shift_b_m) {
  const double angle_rad = turn_rad.norm();
  const Eigen::Matrix3d turn = angle_rad > 0
                                   ? Eigen::AngleAxisd(angle_rad, turn_rad / angle_rad).toRotationMatrix()
                                   : Eigen::Matrix3d(Eigen::Matrix3d::Identity());
  const Vector3d centre_b_m = calibrated_.T_r_l.Inverse().translation_m + shift_b_m;
  real_.T_r_l.rotation = turn * calibrated_.T_r_l.rotation;
  real_.T_r_l.translation_m = -(real_.T_r_l.rotation * centre_b_m);
}

BarPose WatchTraffic::PoseAt(std::size_t machine) const {
  const Course& course = courses_[machine];
  const double t_s = TimeS();
  const auto sine = [t_s](double period_s) { return std::sin(kFullTurnRad * t_s / period_s); };
  const double distance_m = 0.5 * (plan_.nearest_m + plan_.farthest_m) +
                            0.5 * (plan_.farthest_m - plan_.nearest_m) *
                                std::sin(kFullTurnRad * t_s / course.period_s + course.phase_rad);
  const double swing_rad = course.swing_rad * sine(course.swing_s);
  const Vector3d direction(std::cos(swing_rad) * std::cos(course.tilt_rad), std::sin(course.tilt_rad),
                           std::sin(swing_rad) * std::cos(course.tilt_rad));
  const Vector3d middle(course.aside_m + course.sway_m * sine(course.sway_s), course.height_m, distance_m);
  BarPose pose;
  pose.direction_b = frame_.R_b_m * direction;
  pose.led1_b_m = frame_.InRig(middle) - 0.5 * Targets()[machine].LengthM() * pose.direction_b;
  return pose;
}

void WatchTraffic::Show(std::size_t machine) {
  const auto pixels = PixelsOf(real_, Targets()[machine], PoseAt(machine), length_scale_[machine]);
  if (!pixels) return;
  const BarPixels seen = draw_.Noisy(*pixels, plan_.noise_px);
  for (std::size_t i = 0; i < base::kLedCount; ++i) {
    for (std::size_t side = 0; side < 2; ++side) {
      const Vector2d phase_rad = kFullTurnRad * (*pixels)[side][i];
      detect::Blob blob;
      blob.raw_px = seen[side][i] + std::numbers::sqrt2 * plan_.phase_bias_px *
                                        Vector2d(std::sin(phase_rad.x()), std::sin(phase_rad.y()));
      blob.ideal_px = blob.raw_px;  // no distortion
      blob.covariance_px2 = plan_.noise_px * plan_.noise_px * Eigen::Matrix2d::Identity();
      blob.flux_dn = 3000, blob.peak_dn = 206, blob.background_dn = 6, blob.area_px = 30;
      blob.sigma_major_px = blob.sigma_minor_px = 1.5F;
      (*blobs_)[side].blobs.push_back(blob);
    }
  }
}

const stereo::PointSet& WatchTraffic::Next() {
  ++pair_;
  for (std::size_t side = 0; side < 2; ++side) {
    detect::BlobSet& blobs = (*blobs_)[side];
    blobs.blobs.clear();
    blobs.stamp.side = side == 0 ? base::Side::kLeft : base::Side::kRight;
    blobs.stamp.trigger = pair_;
    blobs.stamp.mid_exposure_ns = std::llround(TimeS() * static_cast<double>(base::kNsPerS));
    blobs.stamp.status = base::FrameStatus::kOk;
  }
  for (std::size_t machine = 0; machine < courses_.size(); ++machine) Show(machine);
  pipeline_.Locate((*blobs_)[0], (*blobs_)[1], *result_);
  return result_->points;
}

}  // namespace adit::host
