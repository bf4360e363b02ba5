#include "host/pinhole_bound.h"

#include <Eigen/LU>
#include <cmath>

#include "drivers/sim/projection.h"
#include "firmware/base/require.h"

namespace adit::host {
namespace {

using base::Side;

/// Brightness of a pixel, integrated at 2 x 2 points.
double PixelDn(const sim::SpotPainter& painter, const sim::Disc& disc, double x_px, double y_px) {
  const double point = 0.5 / std::sqrt(3.0);
  double sum_dn = 0;
  for (const double dx : {-point, point}) {
    for (const double dy : {-point, point})
      sum_dn += painter.Value(disc, std::hypot(x_px + dx - disc.x_px, y_px + dy - disc.y_px)) / 4;
  }
  return sum_dn;
}

}  // namespace

double DiscBoundPx(const sim::World& world, const sim::Disc& disc) {
  constexpr double kStepPx = 0.02;  // the painter's profile is a table: finer steps read its steps
  const sim::Sensor& sensor = world.GetScene().sensor;
  const double full_dn = 255;
  const int reach = static_cast<int>(std::ceil(disc.radius_px + 4 * sensor.psf_sigma_px)) + 1;
  const int cx = static_cast<int>(std::lround(disc.x_px)), cy = static_cast<int>(std::lround(disc.y_px));
  const auto moved = [&disc](double dx, double dy) {
    sim::Disc other = disc;
    other.x_px += dx, other.y_px += dy;
    return other;
  };
  Eigen::Matrix4d information = Eigen::Matrix4d::Zero();
  for (int y = cy - reach; y <= cy + reach; ++y) {
    for (int x = cx - reach; x <= cx + reach; ++x) {
      const auto dn = [&](const sim::Disc& at) { return PixelDn(world.Painter(), at, x, y); };
      const double light_dn = dn(disc);
      if (light_dn + sensor.background_dn > full_dn) continue;
      const Eigen::Vector4d slope((dn(moved(kStepPx, 0)) - dn(moved(-kStepPx, 0))) / (2 * kStepPx),
                                  (dn(moved(0, kStepPx)) - dn(moved(0, -kStepPx))) / (2 * kStepPx),
                                  light_dn / disc.flux_dn, 1);
      const double variance =
          sensor.read_noise_dn * sensor.read_noise_dn + light_dn / sensor.electrons_per_dn + 1.0 / 12;
      information += slope * slope.transpose() / variance;
    }
  }
  // The flux is in other units than the rest: scaled, so that the inversion keeps its digits.
  const Eigen::Vector4d scale(1, 1, disc.flux_dn, 1);
  information = (scale.asDiagonal() * information * scale.asDiagonal()).eval();
  return std::sqrt(0.5 * information.inverse().topLeftCorner<2, 2>().trace());
}

Eigen::Matrix3d PointBoundM2(const sim::World& world, const Eigen::Vector3d& point_b_m,
                             const std::array<double, 2>& noise_px) {
  constexpr double kStepM = 1e-3;
  const auto px = [&world](Side side, const Eigen::Vector3d& at_m) {
    const auto seen =
        sim::ProjectPoint(world.Camera(side), side == Side::kLeft ? at_m : world.GetScene().rig.T_r_l * at_m);
    ADIT_REQUIRE(seen);
    return *seen;
  };
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  for (const Side side : {Side::kLeft, Side::kRight}) {
    Eigen::Matrix<double, 2, 3> slope;
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d step = kStepM * Eigen::Vector3d::Unit(i);
      slope.col(i) = (px(side, point_b_m + step) - px(side, point_b_m - step)) / (2 * kStepM);
    }
    const double noise = noise_px[static_cast<std::size_t>(side)];
    information += slope.transpose() * slope / (noise * noise);
  }
  return information.inverse();
}

}  // namespace adit::host
