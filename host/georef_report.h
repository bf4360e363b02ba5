// The report that a surveyor signs.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "host/georeferencing.h"

namespace adit::host {

/// What the report says beside the adjustment.
struct GeorefOrigin {
  std::string control_file, control_crc32;
  std::string measured;                                 ///< track file or recording
  std::string calibration_id;                           ///< of the rig
  std::string time;                                     ///< of the newest measurement, UTC
  std::string surveyor;                                 ///< who; empty: not told
  std::optional<georef::AbsoluteOrientation> previous;  ///< that the new one takes the place of
  std::vector<std::string> unmatched = {};              ///< points of the control file that the track lacks
};

/// Heading (azimuth of the optical axis, clockwise from grid north), pitch (axis upwards), roll (right side
/// downwards) of the rig; radians.
Eigen::Vector3d AttitudeOf(const Eigen::Matrix3d& R_s_b);

/// One standard deviation of the rig's origin (E, N, H; m), and of heading, pitch and roll (rad), times
/// SigmaFactor.
Eigen::Vector3d OriginSigma(const Georeferencing& result);
Eigen::Vector3d AttitudeSigma(const Georeferencing& result);

/// Turns the rig frame into one with x right, y forward in the plane, z up, for a rig of this pitch and roll:
/// HelmertOptions::R_level_b.
Eigen::Matrix3d LevelFrame(double pitch_rad, double roll_rad);

/// How many points of the control file name nothing that the track has, and the first of them: a mistyped
/// name must not pass for a point that was not wanted.
std::string UnmatchedText(const std::vector<std::string>& names);

/// Parameters with standard deviations, sigma0, redundancy, scale in ppm, each point with its residuals and
/// tests, rms, limits and verdict; ASCII, lines of at most 150 characters for usual names.
std::string FormatGeorefReport(const Georeferencing& result, const GeorefOrigin& origin);

/// The georeference file: what the box loads, and how it came about.
std::string FormatGeorefFile(const Georeferencing& result, const GeorefOrigin& origin);

}  // namespace adit::host
