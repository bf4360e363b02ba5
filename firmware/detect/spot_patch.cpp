#include "firmware/detect/spot_patch.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

namespace adit::detect {
namespace {

template <typename Pixel>
void Convert(const std::uint8_t* from, int count, float* to) {
  for (int i = 0; i < count; ++i) {
    Pixel value = 0;
    std::memcpy(&value, from + static_cast<std::ptrdiff_t>(sizeof(Pixel)) * i, sizeof(Pixel));
    to[i] = value;
  }
}

float MeanOfEdge(const SpotPatch& patch) {
  const int width = 2 * patch.reach_x_px + 1, height = 2 * patch.reach_y_px + 1;
  const float* const top = patch.Row(0);
  const float* const bottom = patch.Row(height - 1);
  float sum = 0;  // of whole numbers: exact in any order
  for (int x = 0; x < width; ++x) sum += top[x] + bottom[x];
  for (int y = 1; y < height - 1; ++y) sum += patch.Row(y)[0] + patch.Row(y)[width - 1];
  return sum / static_cast<float>(2 * (width + height) - 4);
}

}  // namespace

bool Load(const base::ImageView& image, const Eigen::Vector2d& middle_px, const Eigen::Vector2d& reach_px,
          int threshold_dn, SpotPatch& patch) {
  patch.x_px = static_cast<int>(std::lround(middle_px.x()));
  patch.y_px = static_cast<int>(std::lround(middle_px.y()));
  const auto reach = [](double wanted_px, int middle, int size_px) {
    return std::min(
        {static_cast<int>(std::ceil(wanted_px)), SpotPatch::kReachMaxPx, middle, size_px - 1 - middle});
  };
  patch.reach_x_px = reach(reach_px.x(), patch.x_px, image.width_px);
  patch.reach_y_px = reach(reach_px.y(), patch.y_px, image.height_px);
  if (patch.reach_x_px < 1 || patch.reach_y_px < 1) return false;
  const int width = 2 * patch.reach_x_px + 1, height = 2 * patch.reach_y_px + 1;
  patch.vectors = (width + SpotPatch::kLanes - 1) / SpotPatch::kLanes;
  const std::ptrdiff_t first_byte = std::ptrdiff_t{image.BytesPerPixel()} * (patch.x_px - patch.reach_x_px);
  const bool wide = image.BytesPerPixel() == 2;
  const auto threshold = static_cast<float>(threshold_dn);
  const int floats = patch.vectors * SpotPatch::kLanes;
  patch.bright_px = 0;
  for (int y = 0; y < height; ++y) {
    const std::uint8_t* const from = image.Row(patch.y_px - patch.reach_y_px + y) + first_byte;
    float* const row = patch.light_dn.data() + static_cast<std::ptrdiff_t>(SpotPatch::kRowFloats) * y;
    (wide ? Convert<std::uint16_t> : Convert<std::uint8_t>)(from, width, row);
    std::fill(row + width, row + floats, 0.0F);
    for (int x = 0; x < floats; ++x) patch.bright_px += row[x] > threshold ? 1 : 0;
  }
  patch.background_dn = MeanOfEdge(patch);
  for (int y = 0; y < height; ++y) {
    float* const row = patch.light_dn.data() + static_cast<std::ptrdiff_t>(SpotPatch::kRowFloats) * y;
    for (int x = 0; x < width; ++x) row[x] -= patch.background_dn;
  }
  return true;
}

}  // namespace adit::detect
