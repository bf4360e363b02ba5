// What is bright where an LED must be that is not seen there.
#pragma once

#include <Eigen/Core>
#include <cstddef>

#include "firmware/identify/sighting_set.h"
#include "firmware/optics/rig.h"

namespace adit::stereo {

/// How a light may stand to a place that it hides.
struct Hiding {
  double beside_px = 0;    ///< from its box
  double flux_min_dn = 0;  ///< of a blob; regions that are none hide however bright they are
};

/// Whether something bright reaches to the image of a point in the left camera (side 0) or the right one.
/// Not where the camera images nothing.
bool IsLit(const optics::Rig& rig, const detect::BlobSet& seen, std::size_t side,
           const Eigen::Vector3d& point_b_m, const Hiding& hiding);

}  // namespace adit::stereo
