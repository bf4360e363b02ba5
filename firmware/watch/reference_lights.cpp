#include "firmware/watch/reference_lights.h"

#include <algorithm>
#include <cmath>

#include "firmware/base/pose.h"
#include "firmware/base/symmetric.h"

namespace adit::watch {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

/// How far from where it is expected a light may be: its place is known to 4 cm at 30 m, and a camera that
/// was knocked by a milliradian is to be found.
constexpr double kReachPx = 5;
/// Brightness against the learned one: fog and a warm LED change it by less, a plate before half of it more.
constexpr double kFluxMin = 0.75, kFluxMax = 1.33;
constexpr int kLightsMin = 3;
/// What the whole rig may turn by against the tunnel: as far as a light is looked for.
constexpr double kRigTurnRad = 1.5e-3;
/// What the right camera may have done, for judging whether the lights agree: as far, and 1 cm.
constexpr double kCameraTurnRad = 1.5e-3, kCameraShiftM = 0.01;
/// Residuals of twice what the centroids state pass, a light that was moved by a tenth of a pixel does not.
constexpr double kChiSquarePerCoordinate = 4;

const detect::Blob* Nearest(const detect::BlobSet& image, const Vector2d& px) {
  const detect::Blob* found = nullptr;
  for (const detect::Blob& blob : image.blobs) {
    const double away_px = (blob.ideal_px - px).norm();
    if (away_px > 2 * kReachPx) continue;
    if (found != nullptr || away_px > kReachPx || blob.merged) return nullptr;  // which of them is it?
    found = &blob;
  }
  return found;
}

bool IsAsBright(double flux_dn, double learned_dn) {
  return flux_dn >= kFluxMin * learned_dn && flux_dn <= kFluxMax * learned_dn;
}

}  // namespace

/// Normal equations of the rig's common motion c (rotation, shift of the points in the rig frame) and of the
/// right camera's motion x.
struct ReferenceLights::Sums {
  MotionMatrix common = MotionMatrix::Zero(), mixed = MotionMatrix::Zero(), motion = MotionMatrix::Zero();
  Motion common_gradient = Motion::Zero(), motion_gradient = Motion::Zero();
  double chi_square = 0;
  int lights = 0;

  /// The common motion projected out.
  Information Reduced(int seconds) const {
    MotionMatrix known = common;
    known.diagonal().head<3>().array() += 1 / (seconds * kRigTurnRad * kRigTurnRad);
    known.diagonal().tail<3>().array() += 1 / (seconds * kSwayM * kSwayM);
    const MotionMatrix pulled = base::SolveSymmetric(known, mixed);
    Information information;
    information.normal = motion - mixed.transpose() * pulled;
    information.gradient = motion_gradient - pulled.transpose() * common_gradient;
    information.chi_square = chi_square - common_gradient.dot(base::SolveSymmetric(known, common_gradient));
    return information;
  }
};

void ReferenceLights::Sight::Add(const std::array<const detect::Blob*, 2>& blobs) {
  for (std::size_t side = 0; side < 2; ++side) {
    stereo::Observation& sum = sums[side];
    if (pairs == 0) sum.px.setZero(), sum.covariance_px2.setZero(), flux_dn[side] = 0;
    sum.px += blobs[side]->ideal_px;
    sum.covariance_px2 += blobs[side]->covariance_px2;
    flux_dn[side] += static_cast<double>(blobs[side]->flux_dn);
  }
  pairs += 1;
}

stereo::Observation ReferenceLights::Sight::Mean(std::size_t side) const {
  const double n = pairs;
  return {sums[side].px / n, sums[side].covariance_px2 / (n * n)};
}

ReferenceLights::ReferenceLights(const stereo::Views& views, const std::vector<Vector3d>& places_b_m)
    : views_(views), lights_(places_b_m.size()) {
  for (std::size_t i = 0; i < lights_.size(); ++i) {
    Eigen::Matrix<double, 2, 3> slope;
    lights_[i].place_b_m = places_b_m[i];
    lights_[i].in_view = views[0].Project(places_b_m[i], lights_[i].px[0], slope) &&
                         views[1].Project(places_b_m[i], lights_[i].px[1], slope);
  }
}

int ReferenceLights::Add(const detect::BlobSet& left, const detect::BlobSet& right) {
  if (!left.whole || !right.whole) return 0;
  int seen = 0;
  for (Light& light : lights_) seen += light.in_view && Look(light, {&left, &right}) ? 1 : 0;
  return seen;
}

bool ReferenceLights::Look(Light& light, const std::array<const detect::BlobSet*, 2>& images) {
  std::array<const detect::Blob*, 2> blobs{};
  const bool learned = light.reference.pairs > 0;
  for (std::size_t side = 0; side < 2; ++side) {
    blobs[side] = Nearest(*images[side], light.px[side]);
    if (blobs[side] == nullptr) return false;
    if (learned && !IsAsBright(static_cast<double>(blobs[side]->flux_dn),
                               light.reference.flux_dn[side] / light.reference.pairs))
      return false;
  }
  light.second.Add(blobs);
  if (!learned) light.learning.Add(blobs);
  return true;
}

ReferenceLights::Sums ReferenceLights::Gather(int seconds) const {
  Sums sums;
  for (const Light& light : lights_) {
    if (light.reference.pairs == 0 || light.second.pairs == 0) continue;
    sums.lights += 1;
    for (std::size_t side = 0; side < 2; ++side) {
      Vector2d seen_px;
      Eigen::Matrix<double, 2, 3> slope;
      if (!views_[side].Project(light.place_b_m, seen_px, slope)) continue;  // in view: it never declines
      const stereo::Observation now = light.second.Mean(side), then = light.reference.Mean(side);
      const stereo::Observation change{now.px - then.px, now.covariance_px2 + seconds * then.covariance_px2};
      const Eigen::Matrix2d w = change.Whitener(std::sqrt(seconds) * kAirPx);
      const Vector2d moved = w * change.px;
      const Eigen::Matrix<double, 2, 3> by_point = w * slope;
      Eigen::Matrix<double, 2, 6> by_common, by_motion = Eigen::Matrix<double, 2, 6>::Zero();
      by_common << -by_point * base::Skew(light.place_b_m), by_point;
      if (side == 1) {
        const Vector3d arm_m = views_[1].rotation * light.place_b_m + views_[1].translation_m;
        by_motion << -by_point * views_[1].rotation.transpose() * base::Skew(arm_m), -by_point;
      }
      sums.common += by_common.transpose() * by_common;
      sums.mixed += by_common.transpose() * by_motion;
      sums.motion += by_motion.transpose() * by_motion;
      sums.common_gradient += by_common.transpose() * moved;
      sums.motion_gradient += by_motion.transpose() * moved;
      sums.chi_square += moved.squaredNorm();
    }
  }
  return sums;
}

std::optional<Information> ReferenceLights::EndSecond(int seconds, std::uint32_t& wrong) {
  const Sums once = Gather(1);
  std::optional<Information> information;
  if (once.lights >= kLightsMin) {
    const Information alone = once.Reduced(1);
    MotionMatrix wide = alone.normal;
    wide.diagonal().head<3>().array() += 1 / (kCameraTurnRad * kCameraTurnRad);
    wide.diagonal().tail<3>().array() += 1 / (kCameraShiftM * kCameraShiftM);
    const double explained = alone.gradient.dot(base::SolveSymmetric(wide, alone.gradient));
    if (alone.chi_square - explained <= kChiSquarePerCoordinate * 4 * once.lights) {
      information = Gather(seconds).Reduced(seconds);
      // Stated for many seconds at once, these say nothing of the noise of one.
      information->chi_square = 0;
    } else {
      wrong += 1;
    }
  }
  for (Light& light : lights_) light.second = {};
  return information;
}

void ReferenceLights::Learn(int pairs_min) {
  for (Light& light : lights_) {
    if (light.reference.pairs > 0 || light.learning.pairs < pairs_min) continue;
    light.reference = light.learning;
    for (std::size_t side = 0; side < 2; ++side) light.px[side] = light.reference.Mean(side).px;
  }
}

void ReferenceLights::Forget() {
  for (Light& light : lights_) light.learning = {};
}

bool ReferenceLights::Learned() const {
  return std::any_of(lights_.begin(), lights_.end(),
                     [](const Light& light) { return light.reference.pairs > 0; });
}

}  // namespace adit::watch
