#include "tests/support/synthetic_bar.h"

#include <algorithm>
#include <cmath>

namespace adit::support {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

std::optional<Vector2d> SyntheticCamera::ProjectIdeal(const Vector3d& point_b_m) const {
  const Vector3d p = rotation * (point_b_m - centre_m);
  if (p.z() <= 0.01) return std::nullopt;
  return Vector2d(cu_px + f_px * p.x() / p.z(), cv_px + f_px * p.y() / p.z());
}

Vector2d SyntheticCamera::Distorted(const Vector2d& ideal_px) const {
  const double x = (ideal_px.x() - cu_px) / f_px, y = (ideal_px.y() - cv_px) / f_px;
  const double r2 = x * x + y * y, radial = k1 * r2 + k2 * r2 * r2;
  const double dx = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x);
  const double dy = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y;
  return ideal_px + f_px * Vector2d(dx, dy);
}

Vector2d SyntheticCamera::Undistorted(const Vector2d& raw_px) const {
  // The plain fixed point, nothing that optics shares; each round gains two digits.
  Vector2d ideal = raw_px;
  for (int i = 0; i < 15; ++i) ideal = raw_px - (Distorted(ideal) - ideal);
  return ideal;
}

bool SyntheticCamera::InImage(const Vector2d& raw_px) const {
  constexpr double kBorderPx = 3;
  return raw_px.x() > kBorderPx && raw_px.y() > kBorderPx && raw_px.x() < width_px - 1 - kBorderPx &&
         raw_px.y() < height_px - 1 - kBorderPx;
}

optics::Rig SyntheticRig::AsRig() const {
  const auto model = [](const SyntheticCamera& c) {
    return optics::CameraModel{c.f_px, c.f_px, c.cu_px, c.cv_px,    c.k1,
                               c.k2,   c.p1,   c.p2,    c.width_px, c.height_px};
  };
  optics::Rig rig;
  rig.left = model(left), rig.right = model(right);
  rig.T_r_l.rotation = right.rotation;
  rig.T_r_l.translation_m = -right.rotation * right.centre_m;
  rig.calibration_id = "synthetic";
  return rig;
}

SyntheticRig ToedInRig(double base_m, double converge_m) {
  // Midway between the cameras, with x along the baseline: the left one turns by a to the right, the right
  // one by a to the left. Then all is expressed in the left one's frame.
  const double a = std::atan(0.5 * base_m / converge_m);
  Matrix3d turn;  // R_r_l, by -2 a about y
  turn << std::cos(2 * a), 0, std::sin(2 * a), 0, 1, 0, -std::sin(2 * a), 0, std::cos(2 * a);
  SyntheticRig rig;
  rig.left.k1 = -0.10, rig.left.k2 = 0.15, rig.left.p1 = 2e-4, rig.left.p2 = -1e-4;
  rig.right.k1 = -0.09, rig.right.k2 = 0.12, rig.right.p1 = -1e-4, rig.right.p2 = 3e-4;
  rig.right.centre_m = base_m * Vector3d(std::cos(a), 0, std::sin(a));
  rig.right.rotation = turn;
  return rig;
}

Vector3d Ahead(const SyntheticRig& rig, double distance_m) {
  const Vector3d axes = Vector3d::UnitZ() + rig.right.rotation.transpose() * Vector3d::UnitZ();
  return 0.5 * rig.right.centre_m + distance_m * axes.normalized();
}

SyntheticBar SyntheticBar::At(const base::Target& target, const Vector3d& middle_m,
                              const Vector3d& direction) {
  SyntheticBar bar;
  bar.target = target;
  bar.direction_b = direction.normalized();
  bar.led1_b_m = middle_m - 0.5 * target.leds_m[3] * bar.direction_b;
  return bar;
}

base::Target SeedTargetOne() { return {"one", {0, 0.25, 0.65, 1.50}, -0.40, 0.04}; }
base::Target SeedTargetTwo() { return {"two", {0, 0.25, 0.80, 1.50}, 0.75, 0.04}; }
base::Target ShortTarget() { return {"short", {0, 0.20, 0.47, 0.82}, 1.20, 0.04}; }

identify::Model ModelOf(const base::Target& target, double nearest_m) {
  constexpr double kFocalPx = 3378;
  const auto& s = target.leds_m;
  const double l = (s[1] / (s[3] - s[1])) / (s[2] / (s[3] - s[2]));
  const double l2 = l * l, l3 = l2 * l, l4 = l3 * l, l5 = l4 * l, l6 = l5 * l;
  const double j = (2 * l6 - 6 * l5 + 9 * l4 - 8 * l3 + 9 * l2 - 6 * l + 2) /
                   (l6 - 3 * l5 + 3 * l4 - l3 + 3 * l2 - 3 * l + 1);
  constexpr double kSpread = 0.05;  // of J, from noise at 120 m
  identify::Model model;
  model.target = target;
  model.p2_min = std::max(2.0, j - kSpread), model.p2_max = std::min(2.8, j + kSpread);
  model.collinearity_max = 0.01;
  model.length_min_px = 0.1 * kFocalPx * s[3] / 120;
  model.length_max_px = kFocalPx * s[3] / nearest_m;
  model.trained_on = "geometry";
  return model;
}

SyntheticScene::SyntheticScene(const SyntheticRig& rig, unsigned seed) : rig_(rig), random_(seed) { Clear(); }

void SyntheticScene::Clear() {
  for (auto* set : {&blobs_.left, &blobs_.right}) {
    set->blobs.clear();
    set->stamp.mid_exposure_ns = 1'000'000'000;
    set->stamp.last_packet_ns = 1'005'000'000;
    set->stamp.trigger = 60;
    set->stamp.status = base::FrameStatus::kOk;
  }
  blobs_.right.stamp.side = base::Side::kRight;
}

bool SyntheticScene::AddBar(const SyntheticBar& bar, double sigma_px) {
  std::array<std::array<Vector2d, base::kLedCount>, 2> raw;
  for (std::size_t side = 0; side < 2; ++side) {
    const SyntheticCamera& camera = side == 0 ? rig_.left : rig_.right;
    for (std::size_t i = 0; i < base::kLedCount; ++i) {
      const auto ideal = camera.ProjectIdeal(bar.Point(bar.target.leds_m[i]));
      if (!ideal) return false;
      raw[side][i] = camera.Distorted(*ideal);
      if (!camera.InImage(raw[side][i])) return false;
    }
  }
  for (const auto& px : raw[0]) AddBlob(base::Side::kLeft, px, sigma_px);
  for (const auto& px : raw[1]) AddBlob(base::Side::kRight, px, sigma_px);
  return true;
}

void SyntheticScene::AddLamps(int count, double sigma_px) {
  for (const auto side : {base::Side::kLeft, base::Side::kRight}) {
    const SyntheticCamera& camera = side == base::Side::kLeft ? rig_.left : rig_.right;
    for (int i = 0; i < count; ++i) {
      const double u = Uniform(4, camera.width_px - 5), v = Uniform(4, camera.height_px - 5);
      AddBlob(side, {u, v}, sigma_px, static_cast<float>(Uniform(200, 20000)));
    }
  }
}

void SyntheticScene::AddBlob(base::Side side, const Vector2d& raw_px, double sigma_px, float flux_dn) {
  const bool is_left = side == base::Side::kLeft;
  const SyntheticCamera& camera = is_left ? rig_.left : rig_.right;
  detect::Blob blob;
  blob.raw_px = raw_px + sigma_px * Vector2d(Gauss(), Gauss());
  blob.ideal_px = camera.Undistorted(blob.raw_px);
  // d ideal / d raw by differences.
  constexpr double kStepPx = 0.5;
  Matrix2d slope;
  for (int c = 0; c < 2; ++c) {
    const Vector2d step = kStepPx * Vector2d::Unit(c);
    slope.col(c) = (camera.Undistorted(raw_px + step) - camera.Undistorted(raw_px - step)) / (2 * kStepPx);
  }
  blob.covariance_px2 = sigma_px * sigma_px * slope * slope.transpose();
  blob.flux_dn = flux_dn;
  blob.peak_dn = 200, blob.background_dn = 6;
  blob.area_px = 30;
  blob.sigma_major_px = blob.sigma_minor_px = 1.5F;
  (is_left ? blobs_.left : blobs_.right).blobs.push_back(blob);
}

void SyntheticScene::Shuffle() {
  std::shuffle(blobs_.left.blobs.begin(), blobs_.left.blobs.end(), random_);
  std::shuffle(blobs_.right.blobs.begin(), blobs_.right.blobs.end(), random_);
}

double SyntheticScene::Uniform(double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random_);
}

double SyntheticScene::Gauss() { return std::normal_distribution<double>()(random_); }

Vector3d SyntheticScene::Direction() {
  Vector3d d;
  do {
    d = {Gauss(), Gauss(), Gauss()};
  } while (d.norm() < 1e-3);
  return d.normalized();
}

}  // namespace adit::support
