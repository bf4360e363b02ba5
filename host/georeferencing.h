// The rig's place in the site grid from points that both the rig and a total station measured.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "firmware/base/result.h"
#include "firmware/georef/absolute_orientation.h"
#include "host/control_points.h"
#include "host/data_snooping.h"
#include "host/helmert.h"
#include "host/rig_points.h"

namespace adit::host {

/// How the points of the two sides are brought together.
struct MatchOptions {
  std::map<std::string, std::string> pairs;  ///< control point -> target or target.LED, where names differ
  std::vector<std::string> excluded;         ///< control points that are compared but not used
  double control_sigma_m = 0.002;            ///< of each coordinate, where the file says none
};

/// A control point that the rig measured too.
struct MatchedPoint {
  CommonPoint common;
  std::string rig_name;  ///< target or target.LED
  std::size_t rows = 0;  ///< of the track that were averaged
  bool used = true;
};

/// Matches by name: a control point is a target's reported point ("bar_a") or one of its LEDs ("bar_a.3"), or
/// what `pairs` says; other points of the file are left alone. Declines: a pair or an excluded point that
/// does not exist, a point that stands twice, has no value or did not stand still; no match at all.
base::Result<std::vector<MatchedPoint>> MatchPoints(const ControlFile& control,
                                                    const std::vector<pipeline::TrackRow>& track,
                                                    const MatchOptions& options);

/// What a georeference must keep to.
struct GeorefLimits {
  double rms_m = 0.003;       ///< of the distances between control and transformed points
  double residual_m = 0.005;  ///< of the largest of them
};

/// A finished adjustment.
struct Georeferencing {
  std::vector<MatchedPoint> points;  ///< the used ones first, in the order of `snooping.tests`
  std::size_t used = 0;
  HelmertOptions options;
  Helmert fit;
  Snooping snooping;
  GeorefLimits limits;
  double scale_ppm = 0, scale_sigma_ppm = 0;  ///< with the scale estimated, whether it is applied or not
  double rms_horizontal_m = 0, rms_vertical_m = 0, rms_m = 0, largest_m = 0;

  /// What sigmas are multiplied by: sigma0 where the points fit worse than their sigmas say, else 1.
  double SigmaFactor() const { return fit.sigma0 > 1 ? fit.sigma0 : 1; }
  /// As the box applies it.
  georef::AbsoluteOrientation Orientation(const std::string& calibration_id) const;
  /// Why it must not be used: a suspected blunder, or a limit that is exceeded; none if it may be.
  std::optional<std::string> Refusal() const;
};

/// Declines as FitHelmert does.
base::Result<Georeferencing> Adjust(std::vector<MatchedPoint> points, const HelmertOptions& options,
                                    const GeorefLimits& limits);

}  // namespace adit::host
