// One bar, seen for a while at nearly one place -> information about the right camera's motion.
#pragma once

#include <array>
#include <optional>

#include "firmware/base/target.h"
#include "firmware/stereo/point_set.h"
#include "firmware/stereo/view.h"
#include "firmware/watch/information.h"

namespace adit::watch {

/// The residuals of one bar over the pairs in which it stayed at one place of the images.
///
/// Noise averages out over these pairs; what a centroid is off by because of where the LED falls on the
/// pixels does not. A coordinate's bias has the period of the pixels: views during which it moves by d < 1 px
/// share it with 1 / d others, so each of them states it that much larger, and all together once. Weight
/// (mean covariance / pairs + bias^2 / d)^-1.
class BarView {
 public:
  /// Adds one pair of a target that was measured in full. Declines, and adds nothing, if a blob is missing or
  /// a LED would be behind a camera.
  bool Add(const stereo::Views& views, const base::Target& target, const stereo::PointSet& set,
           const stereo::TargetPoints& points);

  int Pairs() const { return pairs_; }
  /// Notes where the bar is in this pair, which need not belong to the view any more. Returns how far that is
  /// from where the view began, LED 1 of the image where it is farther, px.
  double MoveTo(const stereo::PointSet& set, const stereo::TargetPoints& points);
  void Clear() { *this = BarView(); }

  /// The information of the mean residuals about the motion, the bar's own five parameters projected out:
  /// normal = J^T M J with J the residuals' derivative by the motion, M the projector onto what no move of
  /// the bar explains. Declines views that no motion of the camera explains (chi-square beyond
  /// `chi_square_max`): a wrong match.
  std::optional<Information> Read(const stereo::Views& views, const base::Target& target, double bias_px,
                                  double chi_square_max) const;

 private:
  using LedSums = std::array<stereo::ObservationPair, base::kLedCount>;

  int pairs_ = 0;
  LedSums sums_;  ///< residuals (seen minus measured) and covariances
  /// Of LED 1, left and right: where the view began, and where the bar came to.
  std::array<Eigen::Vector2d, 2> start_px_{Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()},
      last_px_ = start_px_;
  Eigen::Vector3d epicenter_b_m_ = Eigen::Vector3d::Zero();  ///< of the last pair, with the direction
  Eigen::Vector3d direction_b_ = Eigen::Vector3d::UnitX();
};

}  // namespace adit::watch
