// Bars that the adjustment never saw: does the calibration predict them?
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "firmware/optics/rig.h"
#include "host/bundle.h"

namespace adit::host {

/// The length error of one held-out bar.
struct HeldBar {
  BarKey key;
  double distance_m = 0;
  double error_m = 0, predicted_m = 0;  ///< measured minus stated length; one standard deviation of it
};

struct HoldOut {
  std::vector<HeldBar> bars;
  std::vector<StereoBar> misfits;       ///< wrong pairs among them, left out
  double error_m = 0, predicted_m = 0;  ///< rms of both
  double ratio = 0;                     ///< rms of error over prediction; 1 as predicted
  double reprojection = 0;              ///< residuals against the centroids' covariances, as sigma0

  /// The ratio that chance exceeds once in a thousand for this many bars (Wilson-Hilferty).
  double RatioMax() const;
};

/// A bar in fixed cameras: its place by least squares (5 parameters), and chi2 of the 16 residuals. Declines
/// bars that cannot be placed.
struct FittedBar {
  BarPlace place;
  double chi2 = 0;
};
std::optional<FittedBar> FitBar(const BundleSetting& setting, const optics::Rig& rig, const StereoBar& bar);

/// `bar` as `rig` undistorts it. Declines a centroid outside the lens model.
std::optional<StereoBar> Undistorted(const StereoBar& bar, const optics::Rig& rig);

/// Measures the bars by `rig` with LEDs 1 and 4 triangulated on their own. `setting`: targets with their
/// adjusted lengths, and the noise scale; `covariance` without the bars' common scale, which lengths cannot
/// show. Bars beyond 99.9 % of chi2 count as wrong pairs.
HoldOut TestHoldOut(const BundleSetting& setting, const optics::Rig& rig,
                    const optics::RigCovariance& covariance, std::span<const StereoBar> bars);

}  // namespace adit::host
