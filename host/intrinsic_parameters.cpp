#include "host/intrinsic_parameters.h"

namespace adit::host {

IntrinsicVector Intrinsics(const optics::CameraModel& camera) {
  IntrinsicVector all;
  all << camera.fu_px, camera.fv_px, camera.cu_px, camera.cv_px, camera.k1, camera.k2, camera.p1, camera.p2;
  return all;
}

optics::CameraModel CameraOf(const IntrinsicVector& k, const optics::CameraModel& size) {
  return {k[0], k[1], k[2], k[3], k[4], k[5], k[6], k[7], size.width_px, size.height_px};
}

}  // namespace adit::host
