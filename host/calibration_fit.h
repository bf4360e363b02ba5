// The adjustment of a calibration's bars, wrong pairs among them.
#pragma once

#include <optional>
#include <vector>

#include "host/bundle.h"

namespace adit::host {

/// Bars and points with places to start from.
struct Placed {
  std::vector<StereoBar> bars;
  std::vector<StereoPoint> points;
  BundleState state;
};

/// Those of `bars` and `points` that `rig` can place.
Placed Place(const BundleSetting& setting, const optics::Rig& rig, std::span<const StereoBar> bars,
             std::span<const StereoPoint> points);

struct CalibrationFit {
  std::vector<StereoBar> bars;      ///< right pairs
  std::vector<StereoPoint> points;  ///< lights at rest
  std::vector<StereoBar> misfits;   ///< bars that one rigid rig does not explain
  Bundle bundle;                    ///< least squares over bars and points; empty with fewer bars than asked
  BundleSetting setting;            ///< with the noise scale that the residuals call for, at least 1
};

/// Robust adjustment, wrong pairs out, again, until none leaves; then least squares over the right pairs, the
/// centroids taken as much worse than promised as the residuals say (by the median). Of several candidates of
/// one frame and target the best stays. Declines if the solver does.
std::optional<CalibrationFit> FitCalibration(const BundleSetting& setting, Placed placed,
                                             std::size_t bars_min);

}  // namespace adit::host
