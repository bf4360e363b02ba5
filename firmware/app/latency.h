// Where the time between light and machine goes: a histogram for every part of the way.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "firmware/base/histogram.h"

namespace adit::app {

/// Parts of the way. Exposure stands for its middle, packet for the frame's last packet in memory (for a
/// pair: of the later of the two), result for the fixes, bus for the return of the bus' send.
enum class Span : std::uint8_t {
  kExposureToPacket,
  kPacketToGrab,
  kGrabToDetect,
  kDetect,
  kPairWait,
  kLocate,
  kPairToResult,
  kPacketToResult,
  kExposureToResult,
  kTriggerToResult,
  kResultToBus,
  kPacketToBus,
  kExposureToBus,
};

struct SpanName {
  const char* key;
  const char* what;
};

inline constexpr std::array kSpanNames{
    SpanName{"exposure_to_packet", "mid-exposure -> last packet (read-out, network, Aravis' receiving)"},
    SpanName{"packet_to_grab", "last packet -> taken from Aravis"},
    SpanName{"grab_to_detect", "taken from Aravis -> detection begins"},
    SpanName{"detect", "detection in one image"},
    SpanName{"pair_wait", "one image's blobs wait for the other's"},
    SpanName{"locate", "identification to positions of one pair"},
    SpanName{"pair_to_result", "pair complete -> result"},
    SpanName{"packet_to_result", "last packet -> result"},
    SpanName{"exposure_to_result", "mid-exposure -> result"},
    SpanName{"trigger_to_result", "trigger -> result"},
    SpanName{"result_to_bus", "result -> handed to the bus"},
    SpanName{"packet_to_bus", "last packet -> handed to the bus"},
    SpanName{"exposure_to_bus", "mid-exposure -> handed to the bus"},
};
inline constexpr std::size_t kSpans = kSpanNames.size();
static_assert(kSpans == static_cast<std::size_t>(Span::kExposureToBus) + 1);

/// Written by the hot threads, read by the supervisor; all calls belong to any thread.
class LatencyTable {
 public:
  base::DurationHistogram& operator[](Span span) { return histograms_[static_cast<std::size_t>(span)]; }
  const base::DurationHistogram& At(std::size_t span) const { return histograms_[span]; }

 private:
  std::array<base::DurationHistogram, kSpans> histograms_;
};

}  // namespace adit::app
