// What the pairing thread hands to the publishers and to the track log: the fixes of one pair.
#pragma once

#include "firmware/base/conveyor.h"
#include "firmware/base/image.h"
#include "firmware/georef/geo_fix.h"

namespace adit::app {

struct FixRecord {
  georef::GeoFixSet fixes;
  base::FrameStamp stamp;                      ///< of the left image
  base::TimeNs last_packet_ns = base::kNever;  ///< of the later of the two images
  base::TimeNs result_ns = base::kNever;       ///< the fixes were ready, box clock
};

inline constexpr std::size_t kPublishWaiting = 4;  // the publisher wants the newest only
inline constexpr std::size_t kLogWaiting = 64;     // 1 s at 60 Hz: a disk may pause that long

using PublishConveyor = base::Conveyor<FixRecord, kPublishWaiting>;
using LogConveyor = base::Conveyor<FixRecord, kLogWaiting>;

}  // namespace adit::app
