#include "firmware/stereo/lit_place.h"

#include <algorithm>

namespace adit::stereo {

bool IsLit(const optics::Rig& rig, const detect::BlobSet& seen, std::size_t side,
           const Eigen::Vector3d& point_b_m, const Hiding& hiding) {
  const auto px = side == 0 ? rig.left.Project(point_b_m) : rig.right.Project(rig.T_r_l * point_b_m);
  if (!px) return false;
  const auto reaches = [&](const auto& box) {
    const double beside_px = hiding.beside_px;
    return px->x() >= box.x_min_px - beside_px && px->x() <= box.x_max_px + beside_px &&
           px->y() >= box.y_min_px - beside_px && px->y() <= box.y_max_px + beside_px;
  };
  const auto hides = [&](const detect::Blob& blob) {
    return blob.flux_dn >= hiding.flux_min_dn && reaches(blob);
  };
  return std::any_of(seen.blobs.begin(), seen.blobs.end(), hides) ||
         std::any_of(seen.regions.begin(), seen.regions.end(), reaches);
}

}  // namespace adit::stereo
