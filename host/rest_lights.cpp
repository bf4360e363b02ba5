#include "host/rest_lights.h"

#include <algorithm>
#include <cmath>

#include "host/essential.h"

namespace adit::host {
namespace {

constexpr double kStayPx = 0.5;
constexpr double kFramesMin = 20, kShareMin = 0.5;
constexpr double kScatterMaxPx = 0.1;
// Phase bias of a centroid weighted above a threshold: 0.002 to 0.01 px at peaks from 50 to 400 DN.
constexpr double kBiasPx = 0.01;

RayPair Rays(const optics::Rig& rig, const LedView& left, const LedView& right) {
  return {rig.left.Normalised(left.ideal_px), rig.right.Normalised(right.ideal_px)};
}

bool MayBeOne(const optics::Rig& rig, const Eigen::Matrix3d& essential, const RayPair& rays, double gate_px) {
  const double miss_px = rig.left.fu_px * std::sqrt(SampsonSquared(essential, rays));
  if (!(miss_px <= gate_px)) return false;
  const auto place = Triangulate(rig.T_r_l, rays);
  return place && place->depth_left > 0 && place->depth_right > 0;
}

}  // namespace

RestFinder::Light& RestFinder::At(const Eigen::Vector2d& raw_px) {
  const int column = static_cast<int>(std::floor(raw_px.x())), row = static_cast<int>(std::floor(raw_px.y()));
  for (int u = column - 1; u <= column + 1; ++u) {
    for (int v = row - 1; v <= row + 1; ++v) {
      const auto [first, end] = lights_.equal_range({u, v});
      for (auto light = first; light != end; ++light) {
        if ((light->second.mean_px - raw_px).norm() <= kStayPx) return light->second;
      }
    }
  }
  return lights_.insert({{column, row}, {}})->second;
}

void RestFinder::Add(const detect::BlobSet& blobs) {
  ++frames_;
  for (const detect::Blob& blob : blobs.blobs) {
    Light& light = At(blob.raw_px);
    ++light.count;
    const Eigen::Vector2d step_px = blob.raw_px - light.mean_px;
    light.mean_px += step_px / light.count;
    light.squares_px2 += step_px.dot(blob.raw_px - light.mean_px);
    light.covariance_px2 += (blob.covariance_px2 - light.covariance_px2) / light.count;
  }
}

std::vector<LedView> RestFinder::Lights(const optics::CameraModel& camera) const {
  std::vector<LedView> lights;
  for (const auto& [cell, light] : lights_) {
    const double scatter_px2 = light.squares_px2 / (2 * light.count);  // of a coordinate
    if (light.count < std::max(kFramesMin, kShareMin * frames_) ||
        scatter_px2 > kScatterMaxPx * kScatterMaxPx)
      continue;
    const auto ideal_px = camera.Undistort(light.mean_px);
    if (!ideal_px) continue;
    const double worse = std::max(1.0, scatter_px2 / (0.5 * light.covariance_px2.trace()));
    lights.push_back(
        {light.mean_px, *ideal_px,
         worse * light.covariance_px2 / light.count + kBiasPx * kBiasPx * Eigen::Matrix2d::Identity()});
  }
  return lights;
}

std::vector<StereoPoint> MatchLights(const RestLights& lights, const optics::Rig& rig, double gate_px) {
  const Eigen::Matrix3d essential = base::Skew(rig.T_r_l.translation_m) * rig.T_r_l.rotation;
  std::vector<StereoPoint> points;
  std::vector<std::size_t> uses(lights.right.size(), 0), partner;
  for (const LedView& left : lights.left) {
    std::size_t found = 0, last = 0;
    for (std::size_t j = 0; j < lights.right.size(); ++j) {
      if (!MayBeOne(rig, essential, Rays(rig, left, lights.right[j]), gate_px)) continue;
      ++found, ++uses[j];
      last = j;
    }
    if (found != 1) continue;
    points.push_back({left, lights.right[last]});
    partner.push_back(last);
  }
  std::vector<StereoPoint> unique;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (uses[partner[i]] == 1) unique.push_back(points[i]);
  }
  return unique;
}

}  // namespace adit::host
