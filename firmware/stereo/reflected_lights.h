// Whether a bar is what a mirror makes of lights that are seen beside it.
#pragma once

#include "firmware/stereo/point_cloud.h"
#include "firmware/stereo/solution.h"

namespace adit::stereo {

/// Whether one plane mirror, seen from the cameras' side, would make two LEDs of `bar` of two lights of
/// `cloud` that are alike and no dimmer: then the bar is the reflection of one whose other LEDs are hidden. A
/// bar that is found itself needs no such search (Mirrors). `left` has the cloud's left blobs.
bool ReflectsLights(const Solution& bar, const PointCloud& cloud, const detect::BlobSet& left,
                    const LocatorOptions& options);

}  // namespace adit::stereo
