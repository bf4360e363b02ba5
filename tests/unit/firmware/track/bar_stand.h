// A bar that moves in front of a tracker.
#pragma once

#include "firmware/track/tracker.h"
#include "tests/unit/firmware/track/simulated_bar.h"

namespace adit::tests {

using base::kNsPerMs;
using base::kNsPerS;
using base::TimeNs;
using Eigen::Vector3d;
using stereo::FixStatus;
using track::BarPlace;

inline constexpr TimeNs kPeriodNs = 16 * kNsPerMs;
inline constexpr double kCentreM = 0.6, kEpicenterM = -0.5;
inline const base::Target kBar{"bar", {0, 0.25, 0.65, 1.5}, kEpicenterM, 0.04};

/// A bar in front of a tracker.
struct Stand {
  explicit Stand(unsigned seed = 1, bool filter = false) : truth(seed), tracker({kBar}, {{}, filter, {}}) {
    truth.StartAt({2, 1, 40}, 1, 0.3);
  }

  void Move(TimeNs duration_ns) {
    now_ns += duration_ns;
    truth.Move(1e-9 * static_cast<double>(duration_ns), 2, 2);
  }
  void Show() {
    stereo::PointSet points;
    points.stamp.mid_exposure_ns = now_ns;
    measured = truth.Measure(sigma_m, sigma_rad, kEpicenterM - kCentreM);
    stereo::TargetPoints target;
    target.status = FixStatus::kTracked;
    target.epicenter_b_m = measured.point_b_m;
    target.direction_b = measured.direction_b;
    target.epicenter_covariance_m2 = measured.covariance.topLeftCorner<3, 3>();
    target.direction_covariance = measured.covariance.bottomRightCorner<3, 3>();
    target.epicenter_direction_covariance_m = measured.covariance.topRightCorner<3, 3>();
    points.targets.push_back(target);
    tracker.Track(points, states);
  }
  void Hide() {
    stereo::PointSet points;
    points.stamp.mid_exposure_ns = now_ns;
    points.targets.push_back({});
    tracker.Track(points, states);
  }
  /// One more pair with the bar in it.
  void MoveAndShow() {
    Move(kPeriodNs);
    Show();
  }
  Vector3d Epicenter() const { return truth.CentreM() + (kEpicenterM - kCentreM) * truth.Direction(); }
  const stereo::TargetPoints& Told() const { return states.targets[0].points; }
  bool IsExpectedAfter(TimeNs duration_ns) {
    tracker.Expect(now_ns + duration_ns, expected);
    return expected[0].known;
  }

  SimulatedBar truth;
  Vector3d sigma_m{3e-4, 3e-4, 1.5e-3};
  double sigma_rad = 1e-3;
  BarPlace measured;  ///< last shown
  TimeNs now_ns = kNsPerS;
  track::Tracker tracker;
  track::TargetStateSet states;
  stereo::ExpectationSet expected;
};

}  // namespace adit::tests
