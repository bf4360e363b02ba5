// Positions for tracking software: ART DTrack's ASCII output (interfaces: DTrack manual, "output of
// measurement data via Ethernet"), which vrpn_server, DTrackSDK and game engines read.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "firmware/georef/geo_fix.h"

namespace adit::publish {

/// One pair as a datagram tells it.
struct DtrackPair {
  std::uint32_t number = 0;  ///< `fr`: counts the datagrams
  base::TimeNs mid_exposure_ns = base::kNever;
  base::TimeNs hand_over_ns = base::kNever;  ///< `ts2` tells the latency up to here
  std::array<std::int32_t, 3> origin_s_m{};  ///< positions go out as differences from it
};

/// Lines `fr`, `ts` (seconds of the UTC day), `ts2`, `6dcal`, `6d` and `3d`, each ended by CR LF. A body is a
/// target: its epicenter in mm, and the axes x along the bar from LED 1 to LED 4, z as near to up as can be
/// (a bar has five degrees of freedom: its roll follows gravity), y = z x x. Angles in degrees with R =
/// Rx(eta) Ry(theta) Rz(phi), R column by column. Frame s; without a georeference the rig frame, where up is
/// -y. `3d` holds the bodies' LEDs, numbered 4 x target + LED from 0. What has no position is left out.
class DtrackEncoder {
 public:
  /// Valid until the next call. No heap. One thread.
  std::span<const char> Encode(const georef::GeoFixSet& fixes, const DtrackPair& pair);

 private:
  template <class... Values>
  void Append(const char* format, Values... values);

  static constexpr std::size_t kBodyBytes = 512;  // a body takes up to 220, its four LEDs 60 each
  std::array<char, 256 + kBodyBytes * identify::kMaxTargets> text_{};
  std::size_t size_ = 0;
};

}  // namespace adit::publish
