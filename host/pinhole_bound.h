// What no estimator can beat: the Cramer-Rao bound of an LED's place, by code of the campaigns' own.
#pragma once

#include <Eigen/Core>
#include <array>

#include "drivers/sim/world.h"

namespace adit::host {

/// One standard deviation (px) of a disc's x or y, its brightness and the background unknown, from the
/// noise of the scene's sensor (read, shot, rounding); clipped pixels tell nothing.
double DiscBoundPx(const sim::World& world, const sim::Disc& disc);

/// Covariance (rig frame, m^2) of a point that both cameras measure with these standard deviations of each
/// coordinate (left, right); the projection is the simulator's, its slopes by differences.
Eigen::Matrix3d PointBoundM2(const sim::World& world, const Eigen::Vector3d& point_b_m,
                             const std::array<double, 2>& noise_px);

}  // namespace adit::host
