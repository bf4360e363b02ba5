#include "drivers/sim/scene_keys.h"

#include <cmath>
#include <filesystem>
#include <numbers>

namespace adit::sim {
namespace {

using base::Range;
using base::YamlReader;
using Eigen::Vector3d;

std::string BesideScene(const std::string& scene_path, const std::string& file) {
  return (std::filesystem::path(scene_path).parent_path() / file).string();
}

void ReadTargetKeys(YamlReader& in, base::Target& target) {
  constexpr double kSmallestGapM = 0.001;  // LEDs may touch; two at one place are a slip of the pen
  target.name = in.Text("name");
  if (target.name.find_first_of(",\"/\n") != std::string::npos)
    in.Refuse("name", "must not hold commas, quotes, slashes or line ends");
  const auto leds_m = in.Numbers("leds_m", base::kLedCount, {0, 20});
  target.epicenter_m = in.NumberOr("epicenter_m", 0, {-50, 50});
  target.led_diameter_m = in.NumberOr("led_diameter_m", target.led_diameter_m, {0.001, 0.5});
  for (std::size_t i = 0; in.Ok() && i < leds_m.size(); ++i) {
    target.leds_m[i] = leds_m[i];
    if ((i == 0 && leds_m[0] != 0) || (i > 0 && leds_m[i] - leds_m[i - 1] < kSmallestGapM))
      in.Refuse("leds_m", "must start at 0 and ascend by at least 0.001 m");
  }
}

struct CameraKeys {
  optics::CameraModel model;
  double roll_rad = 0, pitch_rad = 0;
};

CameraKeys ReadCameraKeys(YamlReader& rig, const std::string& side, const optics::CameraModel& shared) {
  CameraKeys keys{shared};
  if (!rig.Has(side)) return keys;
  YamlReader in = rig.Child(side);
  if (in.Has("distortion")) {
    const auto d = in.Numbers("distortion", 4, {-2, 2});
    keys.model.k1 = d[0], keys.model.k2 = d[1], keys.model.p1 = d[2], keys.model.p2 = d[3];
  }
  if (in.Has("centre_px")) {
    const auto centre = in.Numbers("centre_px", 2, {-10000, 20000});
    keys.model.cu_px = centre[0], keys.model.cv_px = centre[1];
  }
  if (side == "right") {
    constexpr double kRadPerDeg = std::numbers::pi / 180;
    keys.roll_rad = in.NumberOr("roll_deg", 0, {-20, 20}) * kRadPerDeg;
    keys.pitch_rad = in.NumberOr("pitch_deg", 0, {-20, 20}) * kRadPerDeg;
  }
  return keys;
}

optics::Rig ReadRigKeys(YamlReader in) {
  optics::CameraModel shared;
  const double base_m = in.Number("base_m", {0.1, 50});
  shared.fu_px = shared.fv_px = in.Number("focal_px", {100, 100000});
  shared.width_px = static_cast<int>(in.IntegerOr("width_px", 1400, {16, 16384}));
  shared.height_px = static_cast<int>(in.IntegerOr("height_px", 1024, {16, 16384}));
  shared.cu_px = (shared.width_px - 1) / 2.0, shared.cv_px = (shared.height_px - 1) / 2.0;
  const double converge_m = in.Number("converge_m", {1, 1e9});
  const CameraKeys left = ReadCameraKeys(in, "left", shared);
  const CameraKeys right = ReadCameraKeys(in, "right", shared);
  // Both look at the point converge_m ahead of the middle of the baseline: in the frame of the middle the
  // left one is turned by +toe about y (down), the right one by -toe, then pitched and rolled.
  const double toe_rad = std::atan2(base_m / 2, converge_m);
  const Eigen::AngleAxisd left_turn(toe_rad, Vector3d::UnitY());
  const Eigen::Matrix3d right_turn = (Eigen::AngleAxisd(-toe_rad, Vector3d::UnitY()) *
                                      Eigen::AngleAxisd(right.pitch_rad, Vector3d::UnitX()) *
                                      Eigen::AngleAxisd(right.roll_rad, Vector3d::UnitZ()))
                                         .toRotationMatrix();
  optics::Rig rig;
  rig.left = left.model;
  rig.right = right.model;
  rig.T_r_l.rotation = right_turn.transpose() * left_turn.toRotationMatrix();
  rig.T_r_l.translation_m = right_turn.transpose() * Vector3d(-base_m, 0, 0);
  rig.calibration_id = "simulated";
  return rig;
}

}  // namespace

Vector3d ReadVector(YamlReader& in, const std::string& key) {
  const auto numbers = in.Numbers(key, 3, kSomewhereM);
  return numbers.size() == 3 ? Vector3d(numbers[0], numbers[1], numbers[2]) : Vector3d::Zero();
}

Vector3d ReadVectorOr(YamlReader& in, const std::string& key, const Vector3d& fallback) {
  return in.Has(key) ? ReadVector(in, key) : fallback;
}

Vector3d ReadDirection(YamlReader& in, const std::string& key) {
  const Vector3d direction = ReadVectorOr(in, key, Vector3d::UnitX());
  if (direction.norm() < 1e-9) {
    in.Refuse(key, "is the zero vector; it must point somewhere");
    return Vector3d::UnitX();
  }
  return direction.normalized();
}

std::vector<Interval> ReadIntervals(YamlReader& in, const std::string& key) {
  std::vector<Interval> intervals;
  for (YamlReader& item : in.Items(key)) {
    Interval interval;
    interval.from_s = item.Number("from_s", kTimeS);
    interval.to_s = item.Number("to_s", {interval.from_s, kTimeS.max});
    intervals.push_back(interval);
  }
  return intervals;
}

MotionPtr GroundMotion(const base::Pose<base::Rig, Ground>& T_b_g) {
  return MakePath({{Waypoint{}}, Curve::kLinear, false}, T_b_g);
}

namespace {

Course ReadPath(YamlReader in) {
  Course course;
  course.curve =
      in.ChoiceOr("curve", "linear", {"linear", "spline"}) == "spline" ? Curve::kSpline : Curve::kLinear;
  course.repeat = in.BoolOr("repeat", false);
  for (YamlReader& item : in.Items("waypoints")) {
    Waypoint waypoint;
    waypoint.t_s = item.Number("t_s", kTimeS);
    waypoint.at_m = ReadVector(item, "at_m");
    waypoint.direction = ReadDirection(item, "direction");
    if (!course.waypoints.empty() && waypoint.t_s <= course.waypoints.back().t_s)
      item.Refuse("t_s", "is not later than that of the waypoint before");
    course.waypoints.push_back(waypoint);
  }
  if (course.waypoints.empty()) {
    in.Refuse("waypoints", "is empty or missing; a path has at least one waypoint");
    course.waypoints.emplace_back();
  }
  return course;
}

Drive ReadDrive(YamlReader in) {
  Drive drive;
  drive.from_m = ReadVector(in, "from_m");
  drive.to_m = ReadVector(in, "to_m");
  drive.duration_s = in.Number("duration_s", {0.1, 1e6});
  drive.weave_m = in.NumberOr("weave_m", 0, {0, 20});
  drive.weave_period_s = in.NumberOr("weave_period_s", 10, {0.5, 1e6});
  drive.vibration_m = in.NumberOr("vibration_m", 0, {0, 1});
  drive.vibration_hz = in.NumberOr("vibration_hz", 20, {0, 1000});
  const Vector3d way_m = drive.to_m - drive.from_m;
  if (in.Ok() && way_m.cross(Vector3d::UnitY()).norm() < 1e-6)
    in.Refuse("to_m", "must differ from from_m other than in height");
  return drive;
}

}  // namespace

MotionPtr ReadMotion(YamlReader& in, const base::Pose<base::Rig, Ground>& T_b_g) {
  const int given = (in.Has("path") ? 1 : 0) + (in.Has("drive") ? 1 : 0) + (in.Has("at_m") ? 1 : 0);
  if (given != 1) {
    in.Refuse("", "must have exactly one of at_m, path and drive, has " + std::to_string(given));
    return GroundMotion(T_b_g);
  }
  if (in.Has("drive")) return MakeDrive(ReadDrive(in.Child("drive")), T_b_g);
  if (in.Has("path")) return MakePath(ReadPath(in.Child("path")), T_b_g);
  Waypoint waypoint;
  waypoint.at_m = ReadVector(in, "at_m");
  waypoint.direction = ReadDirection(in, "direction");
  return MakePath({{waypoint}, Curve::kLinear, false}, T_b_g);
}

base::Target ReadTarget(YamlReader& in, const std::string& scene_path) {
  base::Target target;
  if (!in.Has("file")) {
    ReadTargetKeys(in, target);
    return target;
  }
  const std::string path = BesideScene(scene_path, in.Text("file"));
  auto file = YamlReader::OpenFile(path);
  if (!file) {
    in.Refuse("file", "cannot be used: " + file.error().Line());
    return target;
  }
  ReadTargetKeys(*file, target);
  if (auto done = file->Finish(); !done) in.Refuse("file", "cannot be used: " + done.error().Line());
  return target;
}

optics::Rig ReadRig(YamlReader& in, const std::string& scene_path) {
  if (!in.Has("rig_file")) return ReadRigKeys(in.Child("rig"));
  if (in.Has("rig")) in.Refuse("rig", "stands beside rig_file; give one of them");
  auto rig = optics::LoadRig(BesideScene(scene_path, in.Text("rig_file")));
  if (rig) return *rig;
  in.Refuse("rig_file", "cannot be used: " + rig.error().Line());
  return {};
}

}  // namespace adit::sim
