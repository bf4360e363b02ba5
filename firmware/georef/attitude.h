// How a body stands in the site grid, as machines are told.
#pragma once

#include <Eigen/Core>
#include <optional>

namespace adit::georef {

/// The body's frame is x forward, y left, z up. With its axes in the site frame (easting, northing, height):
/// heading is the azimuth of x, clockwise from grid north, 0 to 2 pi; pitch the elevation of x, up positive;
/// roll the turn about x that follows, positive with the right side down. R_s_t = Rz(90 deg - heading)
/// Ry(-pitch) Rx(roll); FRAMES.md has an example in numbers.
struct Attitude {
  double heading_rad = 0, pitch_rad = 0, roll_rad = 0;
};

/// Nothing within 1 degree of upright, where heading and roll are one and the same.
std::optional<Attitude> AttitudeOf(const Eigen::Matrix3d& R_s_t);

}  // namespace adit::georef
