#include "host/seed_world.h"

#include <Eigen/Geometry>
#include <cmath>

#include "drivers/sim/projection.h"
#include "host/simulated_blobs.h"

namespace adit::host {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kBorderPx = 5, kWaveLeanMax = 0.7, kTurnMaxRad = 0.7853981633974483;
constexpr double kFullTurnRad = 6.283185307179586;

bool IsInside(const optics::CameraModel& camera, const Vector2d& px) {
  return px.x() > kBorderPx && px.y() > kBorderPx && px.x() < camera.width_px - 1 - kBorderPx &&
         px.y() < camera.height_px - 1 - kBorderPx;
}

}  // namespace

MiddleFrame::MiddleFrame(const optics::Rig& rig) {
  const auto T_l_r = rig.T_r_l.Inverse();
  const Vector3d x = T_l_r.translation_m.normalized();
  const Vector3d ahead = Vector3d::UnitZ() + T_l_r.rotation * Vector3d::UnitZ();
  const Vector3d z = (ahead - x.dot(ahead) * x).normalized();
  R_b_m << x, z.cross(x), z;
  origin_b_m = 0.5 * T_l_r.translation_m;
}

std::optional<BarPixels> PixelsOf(const optics::Rig& rig, const base::Target& target, const BarPose& pose,
                                  double length_scale) {
  BarPixels pixels;
  for (std::size_t i = 0; i < base::kLedCount; ++i) {
    const Vector3d led_l_m = pose.Point(length_scale * target.leds_m[i]);
    const auto left = sim::ProjectPoint(rig.left, led_l_m);
    const auto right = sim::ProjectPoint(rig.right, rig.T_r_l * led_l_m);
    if (!left || !right || !IsInside(rig.left, *left) || !IsInside(rig.right, *right)) return std::nullopt;
    pixels[0][i] = *left, pixels[1][i] = *right;
  }
  return pixels;
}

double SeedDraw::Normal() {
  // Box and Muller (1958); one of the two is enough.
  const double radius = std::sqrt(-2 * std::log(1 - random_.Uniform()));
  return radius * std::cos(kFullTurnRad * random_.Uniform());
}

BarPose SeedDraw::Wave(const optics::Rig& rig, const SeedSetup& setup, double length_scale) {
  for (;;) {
    const optics::CameraModel& camera = rig.left;
    const double z_m = Uniform(setup.nearest_m, setup.farthest_m);
    BarPose pose;
    pose.led1_b_m = z_m * Vector3d((Uniform(0, camera.width_px) - camera.cu_px) / camera.fu_px,
                                   (Uniform(0, camera.height_px) - camera.cv_px) / camera.fv_px, 1);
    const double dz = Uniform(-kWaveLeanMax, kWaveLeanMax), turn = Uniform(0, kFullTurnRad);
    const double flat = std::sqrt(1 - dz * dz);
    pose.direction_b = {flat * std::cos(turn), flat * std::sin(turn), dz};
    if (PixelsOf(rig, setup.bar, pose, length_scale)) return pose;
  }
}

BarPose SeedDraw::TurnedAboutTip(const MiddleFrame& frame, const base::Target& target,
                                 const Vector3d& tip_m_m) {
  const double yaw = Uniform(0, kTurnMaxRad), pitch = Uniform(0, kTurnMaxRad), roll = Uniform(0, kTurnMaxRad);
  const Vector3d direction_m = Eigen::AngleAxisd(yaw, Vector3d::UnitY()) *
                               (Eigen::AngleAxisd(pitch, Vector3d::UnitX()) *
                                (Eigen::AngleAxisd(roll, Vector3d::UnitZ()) * Vector3d::UnitY()));
  BarPose pose;
  pose.direction_b = frame.R_b_m * direction_m;
  pose.led1_b_m = frame.InRig(tip_m_m) - target.epicenter_m * pose.direction_b;
  return pose;
}

optics::CameraModel SeedDraw::Mistaken(const optics::CameraModel& truth, const IntrinsicPrior& prior) {
  IntrinsicVector z;
  for (double& value : z) value = Normal();
  return CameraOf(Intrinsics(truth) + prior.root * z, truth);
}

BarPixels SeedDraw::Noisy(const BarPixels& pixels, double noise_px) {
  BarPixels noisy = pixels;
  for (auto& side : noisy) {
    for (Vector2d& px : side) {
      const double du = Normal();
      px += noise_px * Vector2d(du, Normal());
    }
  }
  return noisy;
}

StereoBar StereoBarOf(const optics::Rig& rig, const BarPixels& pixels, double noise_px) {
  StereoBar bar;
  for (std::size_t side = 0; side < 2; ++side) {
    for (std::size_t i = 0; i < base::kLedCount; ++i) {
      LedView& view = (side == 0 ? bar.left : bar.right)[i];
      Eigen::Matrix2d slope;
      view.raw_px = pixels[side][i];
      view.ideal_px = IdealPx(side == 0 ? rig.left : rig.right, pixels[side][i], slope);
      view.covariance_px2 = noise_px * noise_px * slope * slope.transpose();
    }
  }
  return bar;
}

void FillBlobs(const optics::Rig& rig, const BarPixels& pixels, double noise_px,
               std::array<detect::BlobSet, 2>& blobs) {
  const StereoBar bar = StereoBarOf(rig, pixels, noise_px);
  for (std::size_t side = 0; side < 2; ++side) {
    blobs[side].blobs.clear();
    blobs[side].stamp.side = side == 0 ? base::Side::kLeft : base::Side::kRight;
    blobs[side].stamp.status = base::FrameStatus::kOk;
    for (std::size_t i = 0; i < base::kLedCount; ++i) {
      const LedView& view = (side == 0 ? bar.left : bar.right)[i];
      detect::Blob blob;
      blob.raw_px = pixels[side][i];
      blob.ideal_px = view.ideal_px, blob.covariance_px2 = view.covariance_px2;
      blob.flux_dn = 3000, blob.peak_dn = 206, blob.background_dn = 6;
      blob.area_px = 30;
      blob.sigma_major_px = blob.sigma_minor_px = 1.5F;
      blobs[side].blobs.push_back(blob);
    }
  }
}

}  // namespace adit::host
