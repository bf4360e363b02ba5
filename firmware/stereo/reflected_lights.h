// Whether a bar is what a mirror makes of lights that are seen beside it.
#pragma once

#include "firmware/stereo/point_cloud.h"
#include "firmware/stereo/solution.h"

namespace adit::stereo {

/// Whether two lights of `cloud` stand where a plane mirror between them and the cameras' far side would make
/// two LEDs of `bar` of them, alike and no dimmer than it: then the bar is the reflection of one whose other
/// LEDs are hidden. A whole bar and its reflection need no such search (Mirrors). `left` has the cloud's left
/// blobs.
bool ReflectsLights(const Solution& bar, const PointCloud& cloud, const detect::BlobSet& left,
                    const LocatorOptions& options);

}  // namespace adit::stereo
