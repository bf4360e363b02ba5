#include "firmware/detect/spot_patch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "firmware/detect/avx2.h"
#include "firmware/detect/lanes.h"

namespace adit::detect {
namespace {

/// Copies the image's pixels from the patch's first one on, and counts the bright ones. Whole vectors may be
/// read.
template <typename Pixel, int kVectors>
ADIT_INLINE void CopyVectors(const base::ImageView& image, float threshold_dn, SpotPatch& patch) {
  const std::ptrdiff_t first_byte =
      static_cast<std::ptrdiff_t>(sizeof(Pixel)) * (patch.x_px - patch.reach_x_px);
  const std::uint8_t* from = image.Row(patch.y_px - patch.reach_y_px) + first_byte;
  float* to = patch.value_dn.data();
  std::array<Ints, kVectors> bright;  // counted downwards: what is true is -1
  bright.fill(Ints{});
  for (int row = patch.HeightPx(); row > 0; --row, from += image.stride_bytes, to += SpotPatch::kRowFloats) {
    for (std::size_t v = 0; v < kVectors; ++v) {
      std::array<Pixel, kFloatLanes> p;
      std::memcpy(p.data(), from + v * sizeof(p), sizeof(p));
      const Floats value =
          __builtin_convertvector(Ints{p[0], p[1], p[2], p[3], p[4], p[5], p[6], p[7]}, Floats);
      std::memcpy(to + v * kFloatLanes, &value, sizeof(value));
      bright[v] += value > threshold_dn;
    }
  }
  patch.bright_px = 0;
  for (std::size_t x = 0; x < static_cast<std::size_t>(patch.WidthPx()); ++x)
    patch.bright_px -= bright[x / kFloatLanes][x % kFloatLanes];
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

template <typename Pixel, int kVectors>
void CopyBaseline(const base::ImageView& image, float threshold_dn, SpotPatch& patch) {
  CopyVectors<Pixel, kVectors>(image, threshold_dn, patch);
}
template <typename Pixel, int kVectors>
ADIT_AVX2 void CopyAvx2(const base::ImageView& image, float threshold_dn, SpotPatch& patch) {
  CopyVectors<Pixel, kVectors>(image, threshold_dn, patch);
}

template <typename Pixel>
void Copy(const base::ImageView& image, float threshold_dn, SpotPatch& patch) {
  using Copier = void (*)(const base::ImageView&, float, SpotPatch&);
  static constexpr std::array<Copier, kRowVectors> kBaseline{CopyBaseline<Pixel, 1>, CopyBaseline<Pixel, 2>,
                                                             CopyBaseline<Pixel, 3>, CopyBaseline<Pixel, 4>};
  static constexpr std::array<Copier, kRowVectors> kAvx2{CopyAvx2<Pixel, 1>, CopyAvx2<Pixel, 2>,
                                                         CopyAvx2<Pixel, 3>, CopyAvx2<Pixel, 4>};
  const bool whole = patch.x_px - patch.reach_x_px + kFloatLanes * patch.vectors <= image.width_px;
  const auto& copiers = HasAvx2() ? kAvx2 : kBaseline;
  (whole ? copiers[static_cast<std::size_t>(patch.vectors - 1)] : CopyPixels<Pixel>)(image, threshold_dn,
                                                                                     patch);
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
  (image.BytesPerPixel() == 2 ? Copy<std::uint16_t>
                              : Copy<std::uint8_t>)(image, static_cast<float>(threshold_dn), patch);
  patch.background_dn = MeanOfEdge(patch);
  return true;
}

}  // namespace adit::detect
