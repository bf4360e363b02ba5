// A line target as its maker built it.
#pragma once

#include <array>
#include <string>

namespace adit::base {

inline constexpr int kLedCount = 4;

/// Four collinear LEDs on a bar. The direction of the bar is from LED 1 to LED 4.
struct Target {
  std::string name;
  std::array<double, kLedCount> leds_m{};  ///< places along the bar from LED 1, ascending, leds_m[0] == 0
  double epicenter_m = 0;                  ///< the reported point, signed along the bar from LED 1
  double led_diameter_m = 0.04;            ///< of the diffuse sphere

  double LengthM() const { return leds_m[3]; }
};

}  // namespace adit::base
