// How the tracking believes that machines move.
#pragma once

#include "firmware/base/time.h"

namespace adit::track {

/// White noise of the acceleration, as a constant velocity filter has it: after `t` seconds without a
/// measurement a velocity has wandered by a * sqrt(t), a place by a * sqrt(t^3 / 3).
struct MotionOptions {
  /// A machine that brakes or speeds up by 1 m/s^2 for a second needs 0.7. Its engine needs more: 2 mm at
  /// 17 Hz (an idling loader; the seed's table 5.6 has 0.4 to 4.6 mm) is 16 m/s^2 rms that, taken 60 times a
  /// second, looks like 2.3.
  double acceleration_m_per_s2_per_sqrt_hz = 2;
  /// The same shaking at the two ends of a bar of some metres.
  double turning_rad_per_s2_per_sqrt_hz = 2;
  /// Of a whole machine, which weighs tons; what its engine shakes it by stands beside it, as it stays within
  /// bounds: 2 mm at the ends of a machine of 4 m.
  double body_turning_rad_per_s2_per_sqrt_hz = 0.3;
  double body_shake_rad = 0.001;
  /// 1 sigma of what is believed of a target that was seen once; trackless vehicles underground are held to
  /// some 30 km/h = 8 m/s, and a bar that is waved by hand is as fast.
  double speed_m_per_s = 5;
  double rate_rad_per_s = 1.5;
  /// Innovations beyond do not fit: chi-square with 5 degrees of freedom exceeds 40 once in 7 million.
  double chi_square_max = 40;
  /// A lock ends when the expected place is known worse than this (1 sigma, all axes together): a third of
  /// a bar of 1 m, beyond which one LED is easily taken for its neighbour..
  double sigma_max_m = 0.3;
  /// .. or after this long without a measurement: at 8 m/s a vehicle is 4 m further, and somebody else's
  /// lamp may be where it was.
  base::DurationNs coast_max_ns = 500 * base::kNsPerMs;
  /// How long one bar alone holds its body: the turn around it is nobody's but the filter's then, and a
  /// machine that starts to turn by 0.3 rad/s^2 has turned 0.15 rad.
  base::DurationNs one_bar_max_ns = base::kNsPerS;
  /// A jump is confirmed by a second measurement within this time: the next pair at 10 Hz and more.
  base::DurationNs confirm_max_ns = 120 * base::kNsPerMs;
};

}  // namespace adit::track
