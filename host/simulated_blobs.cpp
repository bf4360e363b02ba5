#include "host/simulated_blobs.h"

#include <Eigen/LU>
#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <numeric>

#include "drivers/sim/projection.h"

namespace adit::host {
namespace {

using base::Side;
using Eigen::Matrix2d;
using Eigen::Vector2d;
using std::numbers::pi;

/// A detection's threshold above the background.
constexpr double kBrightDn = sim::kDarkDn;
constexpr double kElongationMax = 2.2, kAreaMinPx = 4, kAreaMaxPx = 1200;  // as detect::DetectorOptions
constexpr double kFullDn = 255;

double Normal(sim::Random& random) {
  const double radius = std::sqrt(-2 * std::log(1 - random.Uniform()));
  return radius * std::cos(2 * pi * random.Uniform());
}

/// Ideal pixel -> raw pixel by the simulator's lens.
Vector2d RawPx(const optics::CameraModel& camera, const Vector2d& ideal_px) {
  const auto px = sim::ProjectPoint(camera, {(ideal_px.x() - camera.cu_px) / camera.fu_px,
                                             (ideal_px.y() - camera.cv_px) / camera.fv_px, 1});
  return px ? *px : Vector2d(Vector2d::Constant(NAN));
}

/// The middle of what is not hidden of a disc of radius 1.
Vector2d MiddleOfShown(std::uint64_t shown) {
  Vector2d sum = Vector2d::Zero();
  for (std::size_t i = 0; i < sim::kDiscPoints; ++i) {
    if ((shown >> i & 1) != 0) sum += sim::DiscPoints()[i];
  }
  return sum / std::popcount(shown);
}

/// A spot's box in the image; at the border it is cut.
detect::Window BoxOf(const Vector2d& low_px, const Vector2d& high_px, const optics::CameraModel& camera) {
  const auto pixel = [](double px, int size_px) {
    return static_cast<int>(std::clamp(px, 0.0, size_px - 1.0));
  };
  return {pixel(low_px.x(), camera.width_px), pixel(low_px.y(), camera.height_px),
          pixel(high_px.x(), camera.width_px), pixel(high_px.y(), camera.height_px)};
}

}  // namespace

double CentroidNoisePx(double peak_dn) {
  // (peak, standard deviation); the last is a spot that is clipped.
  constexpr std::array<std::array<double, 2>, 6> kBound{
      {{12, .108}, {25, .053}, {50, .0277}, {100, .015}, {200, .0084}, {400, .0053}}};
  std::size_t i = 1;
  while (i + 1 < kBound.size() && peak_dn > kBound[i][0]) ++i;
  const auto& [low, high] = std::pair{kBound[i - 1], kBound[i]};
  const double at = std::log(std::min(peak_dn, kBound.back()[0]) / low[0]) / std::log(high[0] / low[0]);
  return low[1] * std::pow(high[1] / low[1], at);
}

Vector2d IdealPx(const optics::CameraModel& camera, const Vector2d& raw_px, Matrix2d& slope) {
  // A lens of a few pixels gains more than a digit a round.
  constexpr int kRounds = 10;
  constexpr double kStepPx = 0.1;
  Vector2d ideal_px = raw_px;
  for (int i = 0; i < kRounds; ++i) ideal_px += raw_px - RawPx(camera, ideal_px);
  Matrix2d raw_slope;
  for (int i = 0; i < 2; ++i) {
    const Vector2d step = kStepPx * Vector2d::Unit(i);
    raw_slope.col(i) = (RawPx(camera, ideal_px + step) - RawPx(camera, ideal_px - step)) / (2 * kStepPx);
  }
  slope = raw_slope.inverse();
  return ideal_px;
}

void SimulatedBlobs::Gather(Side side, double t_s) {
  spots_.clear();
  const double psf_px = world_.GetScene().sensor.psf_sigma_px;
  for (std::size_t i = 0; i < world_.LightCount(); ++i) {
    const auto seen = world_.Receive(i, side, t_s);
    if (!seen || seen->shown == 0) continue;
    sim::Disc disc = seen->disc;
    if (seen->shown != sim::kAllShown) {
      const Vector2d middle = MiddleOfShown(seen->shown);
      disc.x_px += disc.radius_px * middle.x();
      disc.y_px += disc.radius_px * middle.y();
      disc.flux_dn *= std::popcount(seen->shown) / static_cast<double>(sim::kDiscPoints);
    }
    Spot spot;
    spot.x_px = disc.x_px, spot.y_px = disc.y_px;
    spot.extent_px = world_.Painter().ExtentPx(disc, kBrightDn);
    if (spot.extent_px <= 0) continue;
    spot.peak_dn = world_.Painter().Value(disc, 0);
    spot.area_px = pi * spot.extent_px * spot.extent_px;
    // A clipped light weighs by its area.
    spot.flux_dn = std::min(disc.flux_dn, kFullDn * spot.area_px);
    spot.xx = spot.yy = psf_px * psf_px + disc.radius_px * disc.radius_px / 4;
    spot.low_px = Vector2d(disc.x_px, disc.y_px).array() - spot.extent_px;
    spot.high_px = Vector2d(disc.x_px, disc.y_px).array() + spot.extent_px;
    spots_.push_back(spot);
  }
}

void SimulatedBlobs::Join() {
  group_.resize(spots_.size());
  std::iota(group_.begin(), group_.end(), std::size_t{0});
  std::sort(spots_.begin(), spots_.end(), [](const Spot& a, const Spot& b) { return a.x_px < b.x_px; });
  double widest_px = 0;
  for (const Spot& spot : spots_) widest_px = std::max(widest_px, spot.extent_px);
  const auto root = [this](std::size_t i) {
    while (group_[i] != i) i = group_[i] = group_[group_[i]];
    return i;
  };
  for (std::size_t i = 0; i < spots_.size(); ++i) {
    for (std::size_t j = i + 1; j < spots_.size(); ++j) {
      const Spot &a = spots_[i], &b = spots_[j];
      if (b.x_px - a.x_px > a.extent_px + widest_px) break;
      if (std::hypot(b.x_px - a.x_px, b.y_px - a.y_px) < a.extent_px + b.extent_px) group_[root(j)] = root(i);
    }
  }
  std::vector<Spot> joined(spots_.size());
  for (std::size_t i = 0; i < spots_.size(); ++i) {
    const Spot& part = spots_[i];
    Spot& whole = joined[root(i)];
    const double flux_dn = whole.flux_dn + part.flux_dn, share = part.flux_dn / flux_dn;
    const double dx = part.x_px - whole.x_px, dy = part.y_px - whole.y_px;
    const double lever = share * (1 - share);
    whole.xx += share * (part.xx - whole.xx) + lever * dx * dx;
    whole.yy += share * (part.yy - whole.yy) + lever * dy * dy;
    whole.xy += share * (part.xy - whole.xy) + lever * dx * dy;
    whole.x_px += share * dx, whole.y_px += share * dy;
    whole.flux_dn = flux_dn;
    whole.extent_px = std::max(whole.extent_px, part.extent_px);
    whole.peak_dn = std::max(whole.peak_dn, part.peak_dn);
    whole.area_px += part.area_px;
    whole.low_px = whole.low_px.cwiseMin(part.low_px), whole.high_px = whole.high_px.cwiseMax(part.high_px);
  }
  std::erase_if(joined, [](const Spot& spot) { return spot.flux_dn <= 0; });
  spots_ = std::move(joined);
}

void SimulatedBlobs::Append(const Spot& spot, Side side, sim::Random& random, detect::BlobSet& blobs) const {
  const optics::CameraModel& camera = world_.Camera(side);
  const double noise_px =
      fixed_noise_px_ > 0 ? fixed_noise_px_ : noise_scale_ * CentroidNoisePx(spot.peak_dn);
  const Vector2d noise(noise_px * Normal(random), noise_px * Normal(random));
  const double middle = (spot.xx + spot.yy) / 2;
  const double half = std::hypot((spot.xx - spot.yy) / 2, spot.xy);
  const double major_px = std::sqrt(middle + half), minor_px = std::sqrt(std::max(0.01, middle - half));
  const double reach_px = std::max(spot.extent_px, 2 * major_px);
  const bool inside = spot.x_px > reach_px && spot.y_px > reach_px &&
                      spot.x_px < camera.width_px - 1 - reach_px &&
                      spot.y_px < camera.height_px - 1 - reach_px;
  std::uint32_t* const reason = !inside                                ? &blobs.rejects.at_border
                                : spot.area_px < kAreaMinPx            ? &blobs.rejects.too_small
                                : spot.area_px > kAreaMaxPx            ? &blobs.rejects.too_large
                                : major_px > kElongationMax * minor_px ? &blobs.rejects.not_round
                                                                       : nullptr;
  const detect::Window box = BoxOf(spot.low_px, spot.high_px, camera);
  if (reason != nullptr) {
    ++*reason;
    if (reason != &blobs.rejects.too_small) blobs.regions.push_back(box);
    return;
  }
  detect::Blob blob;
  blob.raw_px = Vector2d(spot.x_px, spot.y_px) + noise;
  Matrix2d slope;
  blob.ideal_px = IdealPx(camera, blob.raw_px, slope);
  blob.covariance_px2 = noise_px * noise_px * slope * slope.transpose();
  blob.background_dn = static_cast<float>(world_.GetScene().sensor.background_dn);
  blob.flux_dn = static_cast<float>(spot.flux_dn);
  blob.peak_dn = static_cast<float>(std::min(kFullDn, spot.peak_dn + blob.background_dn));
  blob.saturated = spot.peak_dn + blob.background_dn >= kFullDn;
  blob.area_px = static_cast<float>(spot.area_px);
  blob.sigma_major_px = static_cast<float>(major_px);
  blob.sigma_minor_px = static_cast<float>(minor_px);
  blob.x_min_px = static_cast<std::uint16_t>(box.x_min_px);
  blob.y_min_px = static_cast<std::uint16_t>(box.y_min_px);
  blob.x_max_px = static_cast<std::uint16_t>(box.x_max_px);
  blob.y_max_px = static_cast<std::uint16_t>(box.y_max_px);
  if (!blobs.blobs.push_back(blob)) ++blobs.rejects.no_room;
}

void SimulatedBlobs::Expose(Side side, std::uint64_t trigger, detect::BlobSet& blobs) {
  blobs.blobs.clear();
  blobs.rejects = {};
  blobs.regions.clear();
  blobs.whole = true;
  blobs.background_dn = static_cast<float>(world_.GetScene().sensor.background_dn);
  blobs.noise_dn = static_cast<float>(world_.GetScene().sensor.read_noise_dn);
  blobs.threshold_dn = blobs.background_dn + static_cast<float>(kBrightDn);
  blobs.stamp.mid_exposure_ns = world_.MidExposureNs(trigger);
  blobs.stamp.last_packet_ns = blobs.stamp.mid_exposure_ns + 12 * base::kNsPerMs;  // 1.4 MB at 1 Gbit/s
  blobs.stamp.trigger = trigger;
  blobs.stamp.side = side;
  blobs.stamp.status = base::FrameStatus::kOk;
  Gather(side, world_.MidExposureS(trigger));
  if (together_) Join();
  std::sort(spots_.begin(), spots_.end(), [](const Spot& a, const Spot& b) { return a.y_px < b.y_px; });
  sim::Random random(world_.GetScene().seed ^ 0x626c6f6273, 2 * trigger + static_cast<unsigned>(side));
  for (const Spot& spot : spots_) Append(spot, side, random, blobs);
}

}  // namespace adit::host
