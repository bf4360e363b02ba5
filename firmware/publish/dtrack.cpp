#include "firmware/publish/dtrack.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace adit::publish {
namespace {

constexpr double kMmPerM = 1000, kDegPerRad = 180 / std::numbers::pi;
constexpr base::DurationNs kNsPerDay = 86'400 * base::kNsPerS;

bool HasPosition(const georef::GeoFix& fix) { return fix.state.points.status != stereo::FixStatus::kLost; }

/// The body's axes as columns.
Eigen::Matrix3d AxesOf(const Eigen::Vector3d& direction, bool georeferenced) {
  constexpr double kUpright = 0.999;  // within 2.6 degrees of up gravity says nothing about the roll
  const Eigen::Vector3d up = georeferenced ? Eigen::Vector3d(0, 0, 1) : Eigen::Vector3d(0, -1, 0);
  const Eigen::Vector3d ahead = georeferenced ? Eigen::Vector3d(0, 1, 0) : Eigen::Vector3d(0, 0, 1);
  const Eigen::Vector3d& reference = std::abs(direction.dot(up)) < kUpright ? up : ahead;
  Eigen::Matrix3d axes;
  axes.col(0) = direction;
  axes.col(1) = reference.cross(direction).normalized();
  axes.col(2) = direction.cross(axes.col(1));
  return axes;
}

}  // namespace

template <class... Values>
void DtrackEncoder::Append(const char* format, Values... values) {
  const int length = std::snprintf(text_.data() + size_, text_.size() - size_, format, values...);
  size_ = std::min(size_ + static_cast<std::size_t>(std::max(length, 0)), text_.size() - 1);
}

std::span<const char> DtrackEncoder::Encode(const georef::GeoFixSet& fixes, const DtrackPair& pair) {
  size_ = 0;
  const auto bodies = std::count_if(fixes.targets.begin(), fixes.targets.end(), HasPosition);
  const auto micros = [](base::DurationNs ns) { return static_cast<long long>(ns / base::kNsPerUs); };
  Append("fr %u\r\n", static_cast<unsigned>(pair.number));
  Append("ts %.6f\r\n", static_cast<double>(pair.mid_exposure_ns % kNsPerDay) / base::kNsPerS);
  Append("ts2 %lld %lld %lld\r\n", static_cast<long long>(pair.mid_exposure_ns / base::kNsPerS),
         micros(pair.mid_exposure_ns % base::kNsPerS), micros(pair.hand_over_ns - pair.mid_exposure_ns));
  Append("6dcal %d\r\n6d %d", static_cast<int>(fixes.targets.size()), static_cast<int>(bodies));
  const Eigen::Vector3d origin_m(pair.origin_s_m[0], pair.origin_s_m[1], pair.origin_s_m[2]);
  for (const georef::GeoFix& fix : fixes.targets) {
    if (!HasPosition(fix)) continue;
    const Eigen::Vector3d mm = kMmPerM * (fix.position_s_m - origin_m);
    const Eigen::Matrix3d r = AxesOf(fix.direction_s, fixes.georeferenced);
    Append(" [%d 1.000][%.3f %.3f %.3f", static_cast<int>(fix.state.points.target), mm.x(), mm.y(), mm.z());
    Append(" %.4f %.4f %.4f]", kDegPerRad * std::atan2(-r(1, 2), r(2, 2)),
           kDegPerRad * std::asin(std::clamp(r(0, 2), -1.0, 1.0)),
           kDegPerRad * std::atan2(-r(0, 1), r(0, 0)));
    Append("[%.6f %.6f %.6f %.6f %.6f %.6f %.6f %.6f %.6f]", r(0, 0), r(1, 0), r(2, 0), r(0, 1), r(1, 1),
           r(2, 1), r(0, 2), r(1, 2), r(2, 2));
  }
  Append("\r\n3d %d", static_cast<int>(bodies) * static_cast<int>(base::kLedCount));
  for (const georef::GeoFix& fix : fixes.targets) {
    for (std::size_t led = 0; HasPosition(fix) && led < base::kLedCount; ++led) {
      const Eigen::Vector3d mm = kMmPerM * (fix.leds_s_m[led] - origin_m);
      Append(" [%d 1.000][%.3f %.3f %.3f]",
             static_cast<int>(base::kLedCount) * fix.state.points.target + static_cast<int>(led), mm.x(),
             mm.y(), mm.z());
    }
  }
  Append("%s", "\r\n");
  return {text_.data(), size_};
}

}  // namespace adit::publish
