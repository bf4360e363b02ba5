// Which of the candidate bars are right pairs: those that one epipolar geometry explains.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "firmware/base/target.h"
#include "host/essential.h"
#include "host/stereo_bar.h"

namespace adit::host {

/// The four LEDs of a bar as rays of both cameras.
using RayBar = std::array<RayPair, base::kLedCount>;

/// The similarity check (seed 4.3.3.2, eq. 4.4): a bar seen by both cameras has a similar direction in both
/// images. Angles of LED 1 -> LED 4 to the x and to the y axis may differ by up to `angle_max_rad` each. The
/// limit must leave room for the cameras' own geometry: a bar that leans towards the rig is seen from two
/// sides.
bool LooksSimilar(const StereoBar& bar, double angle_max_rad);

struct ConsensusOptions {
  double gate_px = 3;         ///< largest rms Sampson distance of a right pair's LEDs
  int rounds = 600;           ///< at 40 % wrong pairs a sample of 6 is clean in 1 of 21
  std::uint64_t seed = 4711;  ///< fixed: the same recording gives the same calibration
};

struct Consensus {
  Eigen::Matrix3d essential = Eigen::Matrix3d::Zero();
  std::vector<std::size_t> bars;  ///< indices of the right pairs, ascending
};

/// Random samples of six bars, each an 8-point solution, scored by the truncated sum of squared Sampson
/// distances (MSAC: Torr & Zisserman 2000), the best ones refitted to their right pairs (LO-RANSAC: Chum,
/// Matas, Kittler 2003). `focal_px` turns normalised distances into pixels. Declines fewer than six bars and
/// data without any consensus of six.
std::optional<Consensus> FindConsensus(std::span<const RayBar> bars, double focal_px,
                                       const ConsensusOptions& options);

}  // namespace adit::host
