#include "firmware/detect/light_sums.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "firmware/detect/avx2.h"

namespace adit::detect {
namespace {

constexpr int kPixelsAtOnce = 4;  // pixels
using Doubles = double __attribute__((vector_size(kPixelsAtOnce * sizeof(double))));
using FourInts = std::int32_t __attribute__((vector_size(kPixelsAtOnce * sizeof(std::int32_t))));

template <typename Pixel>
ADIT_INLINE FourInts LoadFour(const Pixel* from) {
  std::array<Pixel, kPixelsAtOnce> four;
  std::memcpy(four.data(), from, sizeof four);  // a camera's rows may begin at odd addresses
  return FourInts{four[0], four[1], four[2], four[3]};
}

ADIT_INLINE double Total(const Doubles& v) { return (v[0] + v[2]) + (v[1] + v[3]); }

/// The sums of a row's pixels, four side by side.
struct FourSums {
  Doubles g{}, x{}, y{}, xx{}, xy{}, yy{}, most{};

  ADIT_INLINE MomentSums Light() const {
    return {Total(g), Total(x), Total(y), Total(xx), Total(xy), Total(yy)};
  }
  ADIT_INLINE double Most() const {
    const double a = most[0] > most[1] ? most[0] : most[1], b = most[2] > most[3] ? most[2] : most[3];
    return a > b ? a : b;
  }
};

/// Pixels side by side, from the origin.
struct Piece {
  double first_x, y;  // px
  int count;
};

/// What is beyond the piece may be anything, but must be readable: four pixels at a time are read.
template <typename Pixel>
ADIT_INLINE void AddPiece(const Pixel* pixels, const Piece& piece, int threshold_dn, FourSums& sums) {
  Doubles g{}, gx{}, gxx{}, place = Doubles{0, 1, 2, 3} + piece.first_x;
  const double end = piece.first_x + piece.count;
  for (int i = 0; i < piece.count; i += kPixelsAtOnce, place += kPixelsAtOnce) {
    const Doubles above = __builtin_convertvector(LoadFour(pixels + i) - threshold_dn, Doubles);
    const Doubles light = place < end ? above : Doubles{};
    const Doubles first = light * place;
    g += light, gx += first, gxx += first * place;
    sums.most = light > sums.most ? light : sums.most;
  }
  const Doubles gy = g * piece.y;
  sums.g += g, sums.x += gx, sums.xx += gxx;
  sums.y += gy, sums.xy += gx * piece.y, sums.yy += gy * piece.y;
}

/// The sums of ones: {1, x, x^2} in the lanes, times the powers of y.
struct OnesSums {
  Doubles of{}, y{}, yy{};

  /// Adds the `count` pixels of the row y from first_x on, by their middle.
  ADIT_INLINE void AddRun(double first_x, double count, double row) {
    const double middle = first_x + 0.5 * (count - 1), x = count * middle;
    const Doubles run{count, x, x * middle + (count * count - 1) * count * (1.0 / 12), 0};
    const Doubles run_y = run * row;
    of += run, y += run_y, yy += run_y * row;
  }
  ADIT_INLINE MomentSums Ones() const { return {of[0], of[1], y[0], of[2], y[1], yy[0]}; }
};

template <typename Pixel>
ADIT_INLINE LightSums Sum(const base::ImageView& image, const RunList& runs, const Eigen::Vector2i& origin_px,
                          int threshold_dn) {
  FourSums four;
  OnesSums ones;
  for (const Run& run : runs) {
    const auto* pixels = reinterpret_cast<const Pixel*>(image.Row(run.y_px)) + run.begin_px;
    const int count = run.end_px - run.begin_px;
    const double x = run.begin_px - origin_px.x(), y = run.y_px - origin_px.y();
    ones.AddRun(x, count, y);
    if (run.end_px + kPixelsAtOnce - 1 <= image.width_px) {
      AddPiece(pixels, {x, y, count}, threshold_dn, four);
      continue;
    }
    // At the end of a row.
    const int most = count / kPixelsAtOnce * kPixelsAtOnce;
    std::array<Pixel, kPixelsAtOnce> rest{};
    std::memcpy(rest.data(), pixels + most, sizeof(Pixel) * static_cast<std::size_t>(count - most));
    AddPiece(pixels, {x, y, most}, threshold_dn, four);
    AddPiece(rest.data(), {x + most, y, count - most}, threshold_dn, four);
  }
  return {four.Light(), ones.Ones(), four.Most()};
}

template <typename Pixel>
LightSums SumBaseline(const base::ImageView& image, const RunList& runs, const Eigen::Vector2i& origin_px,
                      int threshold_dn) {
  return Sum<Pixel>(image, runs, origin_px, threshold_dn);
}
template <typename Pixel>
ADIT_AVX2 LightSums SumAvx2(const base::ImageView& image, const RunList& runs,
                            const Eigen::Vector2i& origin_px, int threshold_dn) {
  return Sum<Pixel>(image, runs, origin_px, threshold_dn);
}

}  // namespace

LightSums SumLight(const base::ImageView& image, const RunList& runs, const Eigen::Vector2i& origin_px,
                   int threshold_dn) {
  const bool bytes = image.BytesPerPixel() == 1;
  const auto sum = HasAvx2() ? (bytes ? SumAvx2<std::uint8_t> : SumAvx2<std::uint16_t>)
                             : (bytes ? SumBaseline<std::uint8_t> : SumBaseline<std::uint16_t>);
  return sum(image, runs, origin_px, threshold_dn);
}

}  // namespace adit::detect
