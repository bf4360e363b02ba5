#include "drivers/sim/motion.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "drivers/sim/projection.h"
#include "drivers/sim/random.h"
#include "firmware/base/require.h"

namespace adit::sim {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;
using std::numbers::pi;

/// Between unit vectors along their great circle; opposite ones over a circle of our choice.
Vector3d TurnBetween(const Vector3d& from, const Vector3d& to, double share) {
  const Quaterniond turn = Quaterniond::FromTwoVectors(from, to);
  return (Quaterniond::Identity().slerp(share, turn) * from).normalized();
}

class Path final : public Motion {
 public:
  Path(Course course, const base::Pose<base::Rig, Ground>& T_b_g) : course_(std::move(course)) {
    ADIT_REQUIRE(!course_.waypoints.empty());
    for (Waypoint& waypoint : course_.waypoints) {
      waypoint.at_m = T_b_g * waypoint.at_m;
      waypoint.direction = T_b_g.rotation * waypoint.direction;
    }
    ground_ = T_b_g.rotation;
  }

  base::Pose<base::Rig, Mobile> At(double t_s) const override {
    const auto& points = course_.waypoints;
    const double first_s = points.front().t_s, length_s = points.back().t_s - first_s;
    if (course_.repeat && length_s > 0) t_s -= length_s * std::floor((t_s - first_s) / length_s);
    const auto after = std::upper_bound(points.begin(), points.end(), t_s,
                                        [](double t, const Waypoint& w) { return t < w.t_s; });
    if (after == points.begin()) return PoseOf(points.front().at_m, points.front().direction);
    if (after == points.end()) return PoseOf(points.back().at_m, points.back().direction);
    const auto i = static_cast<std::size_t>(after - points.begin()) - 1;
    const double share = (t_s - points[i].t_s) / (points[i + 1].t_s - points[i].t_s);
    return PoseOf(course_.curve == Curve::kSpline ? Spline(i, share) : Line(i, share),
                  TurnBetween(points[i].direction, points[i + 1].direction, share));
  }
  bool AtRest() const override { return course_.waypoints.size() == 1; }

 private:
  /// The ground's axes, turned the shortest way until x points along `direction`.
  base::Pose<base::Rig, Mobile> PoseOf(const Vector3d& at_m, const Vector3d& direction) const {
    const Vector3d x = ground_.col(0);
    return {Quaterniond::FromTwoVectors(x, direction).toRotationMatrix() * ground_, at_m};
  }
  Vector3d Line(std::size_t i, double share) const {
    return (1 - share) * course_.waypoints[i].at_m + share * course_.waypoints[i + 1].at_m;
  }
  /// Cubic Hermite with Catmull-Rom's slopes, made for unequal intervals; at the ends one-sided, or wrapped
  /// when it repeats.
  Vector3d Spline(std::size_t i, double share) const {
    const auto& points = course_.waypoints;
    const double step_s = points[i + 1].t_s - points[i].t_s;
    const double u = share, uu = u * u, uuu = uu * u;
    return (2 * uuu - 3 * uu + 1) * points[i].at_m + (uuu - 2 * uu + u) * step_s * SlopeAt(i) +
           (3 * uu - 2 * uuu) * points[i + 1].at_m + (uuu - uu) * step_s * SlopeAt(i + 1);
  }
  Vector3d SlopeAt(std::size_t i) const {
    const auto& points = course_.waypoints;
    const std::size_t last = points.size() - 1;
    const bool wraps = course_.repeat && (i == 0 || i == last);
    const std::size_t before = wraps ? last - 1 : (i == 0 ? 0 : i - 1);
    const std::size_t after = wraps ? 1 : std::min(i + 1, last);
    double span_s = points[after].t_s - points[before].t_s;
    if (wraps) span_s = points[1].t_s - points[0].t_s + points[last].t_s - points[last - 1].t_s;
    return (points[after].at_m - points[before].at_m) / span_s;
  }

  Course course_;
  Eigen::Matrix3d ground_;
};

class DriveMotion final : public Motion {
 public:
  DriveMotion(const Drive& drive, const base::Pose<base::Rig, Ground>& T_b_g) : drive_(drive), T_b_g_(T_b_g) {
    way_m_ = drive.to_m - drive.from_m;
    const Vector3d down = Vector3d::UnitY();
    side_ = down.cross(way_m_).normalized();
  }

  base::Pose<base::Rig, Mobile> At(double t_s) const override {
    const double phase = pi * t_s / drive_.duration_s;
    const double sway = 2 * pi * t_s / drive_.weave_period_s;
    const double shake = 2 * pi * drive_.vibration_hz * t_s;
    base::Pose<Ground, Mobile> pose;
    pose.translation_m =
        drive_.from_m + 0.5 * (1 - std::cos(phase)) * way_m_ + drive_.weave_m * std::sin(sway) * side_ +
        drive_.vibration_m *
            Vector3d(0.6 * std::sin(1.37 * shake + 1), std::sin(shake), 0.4 * std::sin(0.73 * shake + 2));
    // The heading of a vehicle that weaves so at its mean speed; it backs up without turning round.
    const double mean_mps = way_m_.norm() / drive_.duration_s;
    const double sideways_mps = drive_.weave_m * 2 * pi / drive_.weave_period_s * std::cos(sway);
    pose.rotation =
        Eigen::AngleAxisd(std::atan2(sideways_mps, mean_mps), Vector3d::UnitY()).toRotationMatrix();
    return T_b_g_ * pose;
  }
  bool AtRest() const override { return false; }

 private:
  Drive drive_;
  base::Pose<base::Rig, Ground> T_b_g_;
  Vector3d way_m_, side_;
};

bool InsideImage(const optics::CameraModel& camera, const Vector3d& point_m) {
  constexpr double kMarginPx = 12;  // a spot and its window
  const auto px = ProjectPoint(camera, point_m);
  return px && px->x() > kMarginPx && px->y() > kMarginPx && px->x() < camera.width_px - 1 - kMarginPx &&
         px->y() < camera.height_px - 1 - kMarginPx;
}

bool BothSee(const Waypoint& pose, const base::Target& target, const optics::Rig& rig) {
  return std::all_of(target.leds_m.begin(), target.leds_m.end(), [&](double place_m) {
    const Vector3d led_m = pose.at_m + place_m * pose.direction;
    return InsideImage(rig.left, led_m) && InsideImage(rig.right, rig.T_r_l * led_m);
  });
}

Waypoint DrawPose(const Wave& wave, const optics::CameraModel& left, Random& random) {
  Waypoint pose;
  const double z_m = random.Uniform(wave.nearest_m, wave.farthest_m);
  pose.at_m = {z_m * (random.Uniform(0, left.width_px) - left.cu_px) / left.fu_px,
               z_m * (random.Uniform(0, left.height_px) - left.cv_px) / left.fv_px, z_m};
  const double lean = random.Uniform(-wave.lean_max, wave.lean_max);
  const double turn_rad = random.Uniform(0, 2 * pi);
  const double across = std::sqrt(1 - lean * lean);
  pose.direction = {across * std::cos(turn_rad), across * std::sin(turn_rad), lean};
  return pose;
}

}  // namespace

MotionPtr MakePath(const Course& course, const base::Pose<base::Rig, Ground>& T_b_g) {
  return std::make_shared<Path>(course, T_b_g);
}

MotionPtr MakeDrive(const Drive& drive, const base::Pose<base::Rig, Ground>& T_b_g) {
  return std::make_shared<DriveMotion>(drive, T_b_g);
}

std::vector<Waypoint> WaveBar(const Wave& wave, const base::Target& target, const optics::Rig& rig) {
  constexpr int kTries = 100000;  // far more than any rig with a common field of view needs
  Random random(wave.seed, 0x77617665);
  std::vector<Waypoint> poses;
  const auto count = static_cast<std::size_t>(std::ceil(wave.length_s / wave.step_s));
  for (int tries = 0; poses.size() < std::max<std::size_t>(count, 2) && tries < kTries; ++tries) {
    Waypoint pose = DrawPose(wave, rig.left, random);
    if (!BothSee(pose, target, rig)) continue;
    pose.t_s = wave.step_s * static_cast<double>(poses.size());
    poses.push_back(pose);
    tries = 0;
  }
  if (poses.size() < 2) return {};
  Waypoint closing = poses.front();
  closing.t_s = wave.step_s * static_cast<double>(poses.size());
  poses.push_back(closing);
  return poses;
}

base::Pose<base::Rig, Ground> MiddleFrame(const optics::Rig& rig) {
  const base::Pose<base::LeftCamera, base::RightCamera> T_l_r = rig.T_r_l.Inverse();
  const Vector3d x = T_l_r.translation_m.normalized();
  const Vector3d ahead = Vector3d::UnitZ() + T_l_r.rotation.col(2);
  const Vector3d z = (ahead - ahead.dot(x) * x).normalized();
  base::Pose<base::Rig, Ground> T_b_g;
  T_b_g.rotation.col(0) = x;
  T_b_g.rotation.col(1) = z.cross(x);
  T_b_g.rotation.col(2) = z;
  T_b_g.translation_m = 0.5 * T_l_r.translation_m;
  return T_b_g;
}

}  // namespace adit::sim
