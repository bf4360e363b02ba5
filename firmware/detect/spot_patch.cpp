#include "firmware/detect/spot_patch.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "firmware/detect/avx2.h"
#include "firmware/detect/lanes.h"

namespace adit::detect {
namespace {

using Bytes = std::uint8_t __attribute__((vector_size(kFloatLanes)));
using Words = std::uint16_t __attribute__((vector_size(kFloatLanes * sizeof(std::uint16_t))));

/// Copies the image's pixels from the patch's first one on, and counts the bright ones. Whole vectors may be
/// read.
template <typename Pixels>
ADIT_INLINE void CopyVectors(const base::ImageView& image, float threshold_dn, SpotPatch& patch) {
  const std::ptrdiff_t first_byte =
      static_cast<std::ptrdiff_t>(sizeof(Pixels) / kFloatLanes) * (patch.x_px - patch.reach_x_px);
  const Floats end = Floats{} + static_cast<float>(patch.WidthPx());
  Ints bright{};
  for (int row = 0; row < patch.HeightPx(); ++row) {
    const std::uint8_t* from = image.Row(patch.y_px - patch.reach_y_px + row) + first_byte;
    float* to = patch.value_dn.data() + static_cast<std::ptrdiff_t>(SpotPatch::kRowFloats) * row;
    for (int v = 0; v < patch.vectors; ++v, from += sizeof(Pixels), to += kFloatLanes) {
      Pixels pixels;
      std::memcpy(&pixels, from, sizeof(pixels));
      const Floats values = __builtin_convertvector(__builtin_convertvector(pixels, Ints), Floats);
      std::memcpy(to, &values, sizeof(values));
      bright -= (values > threshold_dn) & (kLaneIndex + static_cast<float>(v * kFloatLanes) < end);
    }
  }
  patch.bright_px = 0;
  for (int i = 0; i < kFloatLanes; ++i) patch.bright_px += bright[i];
}

/// The same where vectors would reach beyond the row.
template <typename Pixel>
void CopyPixels(const base::ImageView& image, float threshold_dn, SpotPatch& patch) {
  const int first_px = patch.x_px - patch.reach_x_px;
  patch.bright_px = 0;
  for (int row = 0; row < patch.HeightPx(); ++row) {
    const std::uint8_t* const from = image.Row(patch.y_px - patch.reach_y_px + row);
    float* const to = patch.value_dn.data() + static_cast<std::ptrdiff_t>(SpotPatch::kRowFloats) * row;
    for (int x = 0; x < patch.vectors * kFloatLanes; ++x) {
      Pixel value = 0;
      if (x < patch.WidthPx())
        std::memcpy(&value, from + static_cast<std::ptrdiff_t>(sizeof(Pixel)) * (first_px + x),
                    sizeof(Pixel));
      to[x] = value;
      patch.bright_px += to[x] > threshold_dn ? 1 : 0;
    }
  }
}

void CopyBaseline8(const base::ImageView& image, float threshold_dn, SpotPatch& patch) {
  CopyVectors<Bytes>(image, threshold_dn, patch);
}
ADIT_AVX2 void CopyAvx2Of8(const base::ImageView& image, float threshold_dn, SpotPatch& patch) {
  CopyVectors<Bytes>(image, threshold_dn, patch);
}

void Copy(const base::ImageView& image, float threshold_dn, SpotPatch& patch) {
  const bool whole = patch.x_px - patch.reach_x_px + kFloatLanes * patch.vectors <= image.width_px;
  if (image.BytesPerPixel() == 2) {
    (whole ? CopyVectors<Words> : CopyPixels<std::uint16_t>)(image, threshold_dn, patch);
  } else {
    (!whole ? CopyPixels<std::uint8_t> : HasAvx2() ? CopyAvx2Of8 : CopyBaseline8)(image, threshold_dn, patch);
  }
}

float MeanOfEdge(const SpotPatch& patch) {
  const int width = patch.WidthPx(), height = patch.HeightPx();
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
  patch.vectors = (patch.WidthPx() + kFloatLanes - 1) / kFloatLanes;
  Copy(image, static_cast<float>(threshold_dn), patch);
  patch.background_dn = MeanOfEdge(patch);
  return true;
}

}  // namespace adit::detect
