#include "host/simulated_calibration.h"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

namespace adit::host {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector4d;

constexpr double kPi = 3.14159265358979323846;
constexpr double kWidthPx = 1400, kHeightPx = 1024, kFocalPx = 3378, kMarginPx = 6;
constexpr base::TimeNs kFrameNs = 16'666'667;

/// Pinhole with Brown's distortion.
Vector2d Pixel(const IntrinsicVector& k, const Vector3d& p) {
  if (!(p.z() > 0)) return Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
  const double x = p.x() / p.z(), y = p.y() / p.z(), r2 = x * x + y * y;
  const double radial = 1 + k[4] * r2 + k[5] * r2 * r2;
  return {k[0] * (x * radial + 2 * k[6] * x * y + k[7] * (r2 + 2 * x * x)) + k[2],
          k[1] * (y * radial + k[6] * (r2 + 2 * y * y) + 2 * k[7] * x * y) + k[3]};
}

bool Inside(const Vector2d& px) {
  return px.x() > kMarginPx && px.y() > kMarginPx && px.x() < kWidthPx - kMarginPx &&
         px.y() < kHeightPx - kMarginPx;
}

optics::CameraModel Model(const IntrinsicVector& k) {
  optics::CameraModel size;
  size.width_px = static_cast<int>(kWidthPx), size.height_px = static_cast<int>(kHeightPx);
  return CameraOf(k, size);
}

/// A camera file that is wrong by the prior.
IntrinsicVector Mistaken(const IntrinsicVector& truth, const IntrinsicPrior& prior, sim::Random& random) {
  IntrinsicVector z;
  for (double& value : z) value = Gauss(random);
  return truth + prior.root * z;
}

LedView View(const Vector2d& raw_px, const optics::CameraModel& believed, double noise_px) {
  Eigen::Matrix2d jacobian = Eigen::Matrix2d::Identity();
  const auto ideal = believed.Undistort(raw_px, &jacobian);
  return {raw_px, ideal.value_or(raw_px), noise_px * noise_px * jacobian * jacobian.transpose()};
}

StereoBar Measured(const CalibrationPlan& plan, const CalibrationDraw& draw, std::size_t index,
                   sim::Random& random) {
  std::array<double, base::kLedCount> leds_m = plan.leds_m;
  for (double& place_m : leds_m) place_m *= draw.length_scale;
  const auto seen = Seen(draw.rig, draw.bars[index], leds_m);
  StereoBar bar;
  bar.mid_exposure_ns = static_cast<base::TimeNs>(index) * kFrameNs;
  for (std::size_t i = 0; i < base::kLedCount; ++i) {
    Vector4d raw = seen[i];
    for (double& value : raw) value += plan.noise_px * Gauss(random);
    bar.left[i] = View(raw.head<2>(), draw.input.left, plan.noise_px);
    bar.right[i] = View(raw.tail<2>(), draw.input.right, plan.noise_px);
  }
  return bar;
}

}  // namespace

double Gauss(sim::Random& random) {
  const double radius = std::sqrt(-2 * std::log(1 - random.Uniform()));
  return radius * std::cos(2 * kPi * random.Uniform());
}

Vector4d TrueRig::Project(const Vector3d& point_m) const {
  Vector4d out;
  out << Pixel(left, point_m), Pixel(right, rotation * point_m + translation_m);
  return out;
}

TrueRig TrueRig::Moved(const RigVector& step) const {
  TrueRig moved = *this;
  const Vector3d turn = step.head<3>();
  if (turn.norm() > 0) moved.rotation = Eigen::AngleAxisd(turn.norm(), turn.normalized()) * rotation;
  moved.translation_m += step.segment<3>(3);
  moved.left += step.segment<kIntrinsics>(6);
  moved.right += step.tail<kIntrinsics>();
  return moved;
}

optics::Rig TrueRig::AsRig() const { return {Model(left), Model(right), {rotation, translation_m}, "truth"}; }

TrueRig MakeTrueRig(double base_m, double converge_m) {
  const double toe_rad = std::atan(base_m / 2 / converge_m);
  TrueRig rig;
  rig.left << kFocalPx, kFocalPx, 704.2, 508.9, -0.102, 0.11, 0.0003, -0.0002;
  rig.right << kFocalPx, kFocalPx, 695.1, 514.3, -0.098, 0.10, -0.0002, 0.0004;
  // Rolled and pitched a little, as tripods are.
  rig.rotation = (Eigen::AngleAxisd(0.011, Vector3d::UnitZ()) * Eigen::AngleAxisd(-0.007, Vector3d::UnitX()) *
                  Eigen::AngleAxisd(2 * toe_rad, Vector3d::UnitY()))
                     .toRotationMatrix();
  rig.translation_m =
      -(rig.rotation * Vector3d(base_m * std::cos(toe_rad), 0.05, base_m * std::sin(toe_rad)));
  return rig;
}

std::array<Vector4d, base::kLedCount> Seen(const TrueRig& rig, const TrueBar& bar,
                                           const std::array<double, base::kLedCount>& leds_m) {
  std::array<Vector4d, base::kLedCount> seen;
  for (std::size_t i = 0; i < seen.size(); ++i) seen[i] = rig.Project(bar.led1_m + leds_m[i] * bar.direction);
  return seen;
}

TrueBar WaveBar(const CalibrationPlan& plan, const TrueRig& rig, const Vector2d& distance_m,
                sim::Random& random) {
  for (;;) {
    const double z = random.Uniform(distance_m[0], distance_m[1]);
    const Vector3d led1(z * random.Uniform(-0.5, 0.5) * kWidthPx / kFocalPx,
                        z * random.Uniform(-0.5, 0.5) * kHeightPx / kFocalPx, z);
    const double dz = random.Uniform(-plan.lean_max, plan.lean_max), turn = random.Uniform(0, 2 * kPi);
    const double flat = std::sqrt(1 - dz * dz);
    const TrueBar bar{led1, Vector3d(flat * std::cos(turn), flat * std::sin(turn), dz)};
    bool is_seen = true;
    for (const Vector4d& led : Seen(rig, bar, plan.leds_m))
      is_seen = is_seen && Inside(led.head<2>()) && Inside(led.tail<2>());
    if (is_seen) return bar;
  }
}

CalibrationDraw Draw(const CalibrationPlan& plan, std::uint64_t seed) {
  sim::Random random(seed);
  CalibrationDraw draw;
  draw.rig = MakeTrueRig(plan.base_m, plan.converge_m);
  CalibrationInput& input = draw.input;
  input.recordings = {"simulated"};
  base::Target target;
  target.name = "wand";
  target.leds_m = plan.leds_m;
  input.targets = {target};
  input.bar_sigma_m = plan.bar_sigma_m;
  input.left_prior = PriorOf(plan.intrinsics, Model(draw.rig.left));
  input.right_prior = PriorOf(plan.intrinsics, Model(draw.rig.right));
  input.left = Model(Mistaken(draw.rig.left, input.left_prior, random));
  input.right = Model(Mistaken(draw.rig.right, input.right_prior, random));
  draw.length_scale = 1 + Gauss(random) * plan.bar_sigma_m / target.LengthM();
  const auto far = static_cast<std::size_t>(plan.far_share * static_cast<double>(plan.bars));
  for (std::size_t i = 0; i < plan.bars; ++i) {
    const Vector2d distance_m =
        i < far ? Vector2d(plan.farthest_m, plan.farthest_far_m) : Vector2d(plan.nearest_m, plan.farthest_m);
    draw.bars.push_back(WaveBar(plan, draw.rig, distance_m, random));
    input.bars.push_back(Measured(plan, draw, i, random));
  }
  return draw;
}

}  // namespace adit::host
