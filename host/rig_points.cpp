#include "host/rig_points.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace adit::host {
namespace {

using base::Error;
using base::ErrorCode;
using Eigen::Vector3d;
using pipeline::TrackRow;
using stereo::FixStatus;

constexpr double kFarthestM = 1000;   // farther than any camera sees an LED
constexpr double kMovesAbove = 5;     // sigmas of a row
constexpr std::size_t kFewRows = 10;  // fewer say little of their scatter

bool Measured(const TrackRow& row, const RigPointName& name) {
  if (row.target != name.target) return false;
  if (row.status != FixStatus::kTracked && row.status != FixStatus::kRecovered) return false;
  return name.led == 0 || (row.recovered_mask >> (name.led - 1) & 1) == 0;
}

Vector3d PlaceIn(const TrackRow& row, const RigPointName& name) {
  return name.led == 0 ? row.position_m : row.leds_m[static_cast<std::size_t>(name.led - 1)];
}

Error Refuse(const RigPointName& name, const std::string& detail) {
  return {ErrorCode::kFailed, name.Text(), detail};
}

Error RefuseMoving(const RigPointName& name, const Vector3d& scatter_m, const Vector3d& sigma_m) {
  std::ostringstream text;
  text << "does not stand still: its places scatter by " << scatter_m.norm() * 1e3 << " mm, where "
       << sigma_m.norm() * 1e3 << " mm are expected of one that does";
  return Refuse(name, text.str());
}

}  // namespace

std::string RigPointName::Text() const { return led == 0 ? target : target + "." + std::to_string(led); }

std::optional<RigPointName> FindRigPoint(const std::vector<TrackRow>& track, const std::string& name) {
  const auto has = [&track](const std::string& target) {
    return std::any_of(track.begin(), track.end(),
                       [&target](const TrackRow& row) { return row.target == target; });
  };
  if (has(name)) return RigPointName{name, 0};
  const std::size_t dot = name.rfind('.');
  if (dot == std::string::npos || dot + 2 != name.size()) return std::nullopt;
  const int led = name.back() - '0';
  if (led < 1 || led > base::kLedCount || !has(name.substr(0, dot))) return std::nullopt;
  return RigPointName{name.substr(0, dot), led};
}

base::Result<RigPoint> AverageRigPoint(const std::vector<TrackRow>& track, const RigPointName& name) {
  RigPoint point;
  Vector3d told_m2 = Vector3d::Zero(), scatter_m2 = Vector3d::Zero();
  for (const TrackRow& row : track) {
    if (!Measured(row, name)) continue;
    ++point.rows;
    point.mean_b_m += PlaceIn(row, name);
    told_m2 += row.sigma_m.cwiseAbs2();
  }
  if (point.rows == 0) return Refuse(name, "was never measured in this track");
  const auto rows = static_cast<double>(point.rows);
  point.mean_b_m /= rows;
  if (point.mean_b_m.norm() > kFarthestM)
    return Refuse(name, "lies more than 1000 m from the rig; the track must be in the rig frame");
  for (const TrackRow& row : track) {
    if (Measured(row, name)) scatter_m2 += (PlaceIn(row, name) - point.mean_b_m).cwiseAbs2();
  }
  const Vector3d told_m = (told_m2 / rows).cwiseSqrt();
  const Vector3d scatter_m =
      point.rows < kFewRows ? Vector3d::Zero() : Vector3d((scatter_m2 / (rows - 1)).cwiseSqrt());
  if ((scatter_m.array() > kMovesAbove * told_m.array()).any()) return RefuseMoving(name, scatter_m, told_m);
  point.sigma_m = told_m.cwiseMax(scatter_m) / std::sqrt(rows);
  return point;
}

}  // namespace adit::host
