#include "firmware/stereo/bar_builder.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "firmware/stereo/correspondence.h"

namespace adit::stereo {

using base::kLedCount;

namespace {

/// Whether what counts as one light is as bright, as far as the two distances tell, in the right image as in
/// the left one: after a factor that all LEDs of the bar have in common. One that is not has merged with a
/// lamp in one of the images or is covered there in part, and its centroid is not where the LED is.
bool AreSameLights(const Views& views, const TargetPoints& points) {
  constexpr double kWithin = 1.5;  // LEDs near the cameras show each of them another side
  double least = HUGE_VAL, most = 0;
  for (std::size_t i = 0; i < kLedCount; ++i) {
    const double left_dn = points.flux_dn[0][i], right_dn = points.flux_dn[1][i];
    if (!(left_dn > 0 && right_dn > 0)) continue;
    const double ratio = right_dn * (points.leds_b_m[i] - views[1].CentreM()).squaredNorm() /
                         (left_dn * (points.leds_b_m[i] - views[0].CentreM()).squaredNorm());
    least = std::min(least, ratio), most = std::max(most, ratio);
  }
  return most <= kWithin * least;
}

}  // namespace

BarBuilder::BarBuilder(const optics::Rig& rig, const LocatorOptions& options)
    : views_(MakeViews(rig)), solver_(rig, options), options_(options) {}

void BarBuilder::Set(const detect::BlobSet& left, const detect::BlobSet& right) { blobs_ = {&left, &right}; }

std::optional<Solution> BarBuilder::Build(const base::Target& target, const BarBlobs& blobs,
                                          LossReason& reason) const {
  BarObservations observations;
  LedFlux flux_dn{};
  double left_flux_dn = 0, count = 0;
  for (std::size_t i = 0; i < kLedCount; ++i) {
    for (std::size_t side = 0; side < 2; ++side) {
      const std::uint16_t index = blobs[side][i];
      if (index == kNoBlob) {
        observations[i][side].seen = false;
        continue;
      }
      const detect::Blob& blob = blobs_[side]->blobs[index];
      observations[i][side] = ObservationOf(blob);
      flux_dn[side][i] = blob.flux_dn;
      if (side == 0) left_flux_dn += static_cast<double>(blob.flux_dn), ++count;
    }
  }
  auto solution = solver_.Solve(target, observations, reason);
  if (!solution) return std::nullopt;
  solution->flux_dn = left_flux_dn / count;
  solution->points.flux_dn = flux_dn;
  solution->points.blobs = blobs;
  reason = LossReason::kNoCorrespondence;
  if (!AreSameLights(views_, solution->points)) return std::nullopt;
  reason = LossReason::kNone;
  return solution;
}

std::uint16_t BarBuilder::NearestTo(const base::Target& target, const Solution& solution, std::size_t led,
                                    std::size_t side) const {
  const double place_m = target.leds_m[led];
  Eigen::Vector2d px;
  Eigen::Matrix<double, 2, 3> slope;
  if (!views_[side].Project(solution.fit.PointM(target, place_m), px, slope)) return kNoBlob;
  const double floor_px2 = options_.centroid_floor_px * options_.centroid_floor_px;
  const Eigen::Matrix2d place_px2 =
      slope * solution.fit.PointCovarianceM2(target, place_m) * slope.transpose() +
      floor_px2 * Eigen::Matrix2d::Identity();
  const auto& taken = solution.points.blobs[side];
  // What the rig may have turned moves the right image as a whole; the fit shares it between the images.
  const double aside_px = 0.5 * options_.epipolar_px;
  const double widest_px = options_.sigmas * std::sqrt(place_px2.trace()) + aside_px;
  std::uint16_t nearest = kNoBlob;
  double least = options_.sigmas * options_.sigmas;
  for (std::size_t i = 0; i < blobs_[side]->blobs.size(); ++i) {
    const detect::Blob& blob = blobs_[side]->blobs[i];
    const Eigen::Vector2d offset = blob.ideal_px - px;
    const double blob_px2 = blob.covariance_px2.trace();
    // Written so that NaN is passed over.
    if (!(offset.squaredNorm() <= 2 * (widest_px * widest_px + options_.sigmas * options_.sigmas * blob_px2)))
      continue;
    const Eigen::Matrix2d all_px2 =
        place_px2 + blob.covariance_px2 + aside_px * aside_px / 4 * Eigen::Matrix2d::Identity();
    const double distance = offset.dot(all_px2.inverse() * offset);
    const auto index = static_cast<std::uint16_t>(i);
    if (!(distance < least) || std::find(taken.begin(), taken.end(), index) != taken.end()) continue;
    least = distance, nearest = index;
  }
  return nearest;
}

std::optional<Solution> BarBuilder::With(const base::Target& target, const Solution& solution,
                                         std::size_t led, std::size_t side, const LedFlux& known) const {
  const std::uint16_t nearest = NearestTo(target, solution, led, side);
  if (nearest == kNoBlob) return std::nullopt;
  BarBlobs blobs = solution.points.blobs;
  blobs[side][led] = nearest;
  LossReason unused;
  const auto more = Build(target, blobs, unused);
  // Two more coordinates may cost what two coordinates do, and no more.
  if (!more || more->chi_square > solution.chi_square + ChiSquareLimit(2, options_.chi_square_sigmas))
    return std::nullopt;
  return SameBrightness(known, more->points.flux_dn) ? more : std::nullopt;
}

Solution BarBuilder::Completed(const base::Target& target, const Solution& solution,
                               const LedFlux& known) const {
  Solution best = solution;
  for (std::size_t led = 0; led < kLedCount; ++led) {
    if (best.points.blobs[0][led] != kNoBlob) continue;
    const auto with_left = With(target, best, led, 0, known);
    const auto with_right = With(target, with_left ? *with_left : best, led, 1, known);
    if (with_left && with_right)
      best = *with_right;
    else if (with_left && IsUncovered(known, with_left->points.flux_dn, 0, led))
      best = *with_left;
    else if (with_right && IsUncovered(known, with_right->points.flux_dn, 1, led))
      best = *with_right;
  }
  return best;
}

}  // namespace adit::stereo
