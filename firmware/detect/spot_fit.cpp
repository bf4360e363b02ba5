#include "firmware/detect/spot_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "firmware/detect/lanes.h"

namespace adit::detect {
namespace {

// A model is a sum of round Gaussians, whose parameters are linear in the model's: height, x, y, square of
// the width of each, and the background of all.
constexpr int kPerSpot = 4, kSpotsMax = 3, kRawMax = kPerSpot * kSpotsMax + 1;
using RawVector = Eigen::Matrix<double, kRawMax, 1>;
using RawMatrix = Eigen::Matrix<double, kRawMax, kRawMax>;
/// The Gaussians' parameters from the model's.
struct ModelMap {
  int spots = 0;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kRawMax, kFitParametersMax> from;
};

ModelMap MapOf(SpotModel model) {
  const bool smeared = model == SpotModel::kSmeared, two = model == SpotModel::kTwo;
  const int spots = smeared ? 3 : two ? 2 : 1, parameters = smeared ? 7 : two ? 8 : 5;
  ModelMap map{spots, {}};
  map.from.setZero(kPerSpot * spots + 1, parameters);
  // Gauss and Legendre's three points of a line: as good as the whole up to the fifth moment.
  constexpr std::array<double, 3> kPart{5 / 18.0, 8 / 18.0, 5 / 18.0},
      kPlace{-0.3872983346207417, 0, 0.3872983346207417};
  for (int i = 0; i < spots; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const int row = kPerSpot * i, first = two ? 3 * i : 0;
    map.from(row, first) = smeared ? kPart[k] : 1;
    map.from(row + 1, first + 1) = map.from(row + 2, first + 2) = 1;
    if (smeared) map.from(row + 1, 3) = map.from(row + 2, 4) = kPlace[k];
    map.from(row + 3, parameters - 2) = 1;
  }
  map.from(kPerSpot * spots, parameters - 1) = 1;
  return map;
}

/// Of every pixel 1 / variance, and 0 beyond the patch's edge and where it clips. From the pixels themselves:
/// they are off by a hundredth, which costs nothing, and stay the same while the fit moves.
struct Weights {
  alignas(32) std::array<float, SpotPatch::kFloats> of;
  int count = 0;
  double energy = 0;  ///< sum of weight times light squared
};

void Weigh(const SpotPatch& patch, const PixelLimits& pixels, Weights& weights) {
  const auto dark_dn2 = static_cast<float>(
      pixels.noise.VarianceDn2(std::max<double>(patch.background_dn, pixels.noise.background_dn)));
  const auto slope_dn = static_cast<float>(1 / pixels.noise.electrons_per_dn);
  const auto clipped_dn = static_cast<float>(pixels.full_dn);
  const int width = patch.WidthPx(), height = patch.HeightPx();
  weights.count = 0, weights.energy = 0;
  for (int row = 0; row < height; ++row) {
    const float* const values = patch.Row(row);
    float* const to = weights.of.data() + static_cast<std::ptrdiff_t>(SpotPatch::kRowFloats) * row;
    for (int x = 0; x < patch.vectors * kFloatLanes; ++x) {
      const float light_dn = values[x] - patch.background_dn;
      const bool known = x < width && values[x] < clipped_dn;
      to[x] = known ? 1 / (dark_dn2 + slope_dn * std::max(light_dn, 0.F)) : 0.F;
      weights.count += known ? 1 : 0;
      weights.energy += static_cast<double>(to[x] * light_dn * light_dn);
    }
  }
}

/// Sums over the pixels: of products of derivatives, of derivatives times residuals, of residuals squared.
struct NormalEquations {
  RawMatrix products;
  RawVector slopes;
  double chi2 = 0;
};

template <int kSpots>
struct Accumulator {
  static constexpr int kRaw = kPerSpot * kSpots + 1;
  std::array<Floats, kRaw*(kRaw + 1) / 2> products{};
  std::array<Floats, kRaw> slopes{};
  Floats chi2{};

  ADIT_INLINE void Take(const std::array<Floats, kRaw>& derivative, const Floats& residual,
                        const Floats& weight) {
    std::size_t at = 0;
    const Floats weighted = weight * residual;
    for (std::size_t i = 0; i < kRaw; ++i) {
      const Floats d = weight * derivative[i];
      for (std::size_t j = 0; j <= i; ++j) products[at++] += d * derivative[j];
      slopes[i] += weighted * derivative[i];
    }
    chi2 += weighted * residual;
  }
  ADIT_INLINE NormalEquations Sums() const {
    NormalEquations out;
    std::size_t at = 0;
    for (int i = 0; i < kRaw; ++i) {
      for (int j = 0; j <= i; ++j) out.products(i, j) = out.products(j, i) = SumLanes(products[at++]);
      out.slopes[i] = SumLanes(slopes[static_cast<std::size_t>(i)]);
    }
    out.chi2 = SumLanes(chi2);
    return out;
  }
};

/// One Gaussian on the patch: its factors along a row and down a column.
struct Factors {
  FloatsRow dx, across, down;
  float height = 0, y_px = 0, per_size = 0;

  ADIT_INLINE void Set(double height_dn, double x_px, double y, double size_px2) {
    height = static_cast<float>(height_dn), y_px = static_cast<float>(y),
    per_size = static_cast<float>(1 / size_px2);
    for (std::size_t v = 0; v < static_cast<std::size_t>(kRowVectors); ++v) {
      const Floats place = kLaneIndex + static_cast<float>(v * kFloatLanes);
      dx[v] = place - static_cast<float>(x_px);
      const Floats dy = place - y_px;
      across[v] = -0.5F * per_size * dx[v] * dx[v];
      down[v] = -0.5F * per_size * dy * dy;
      Exp(across[v]), Exp(down[v]);
    }
  }
};

template <int kSpots>
ADIT_INLINE NormalEquations Accumulate(const SpotPatch& patch, const Weights& weights, const RawVector& raw) {
  std::array<Factors, kSpots> spots;
  for (std::size_t k = 0; k < kSpots; ++k) {
    const auto of = raw.segment<kPerSpot>(kPerSpot * static_cast<Eigen::Index>(k));
    spots[k].Set(of[0], of[1], of[2], of[3]);
  }
  const float background = patch.background_dn + static_cast<float>(raw[kPerSpot * kSpots]);
  Accumulator<kSpots> sums;
  std::array<Floats, Accumulator<kSpots>::kRaw> derivative;
  derivative.back() = Floats{} + 1.F;
  for (int row = 0; row < patch.HeightPx(); ++row) {
    const std::size_t first = static_cast<std::size_t>(SpotPatch::kRowFloats * row);
    for (std::size_t v = 0; v < static_cast<std::size_t>(patch.vectors); ++v) {
      Floats residual, weight;
      std::memcpy(&residual, patch.value_dn.data() + first + v * kFloatLanes, sizeof(residual));
      std::memcpy(&weight, weights.of.data() + first + v * kFloatLanes, sizeof(weight));
      residual -= background;
      for (std::size_t k = 0; k < kSpots; ++k) {
        const Factors& s = spots[k];
        const float dy = static_cast<float>(row) - s.y_px;
        Floats* const d = derivative.data() + kPerSpot * k;
        d[0] = s.across[v] * s.down[static_cast<std::size_t>(row / kFloatLanes)][row % kFloatLanes];
        const Floats light = s.height * d[0], slope = light * s.per_size;
        residual -= light;
        d[1] = slope * s.dx[v], d[2] = slope * dy;
        d[3] = (d[1] * s.dx[v] + d[2] * dy) * (0.5F * s.per_size);
      }
      sums.Take(derivative, residual, weight);
    }
  }
  return sums.Sums();
}

template <int kSpots>
NormalEquations AccumulateBaseline(const SpotPatch& patch, const Weights& weights, const RawVector& raw) {
  return Accumulate<kSpots>(patch, weights, raw);
}
template <int kSpots>
ADIT_AVX2 NormalEquations AccumulateAvx2(const SpotPatch& patch, const Weights& weights,
                                         const RawVector& raw) {
  return Accumulate<kSpots>(patch, weights, raw);
}
template <int kSpots>
NormalEquations AccumulateFastest(const SpotPatch& patch, const Weights& weights, const RawVector& raw) {
  return (HasAvx2() ? AccumulateAvx2<kSpots> : AccumulateBaseline<kSpots>)(patch, weights, raw);
}

/// The normal equations of the model's own parameters.
struct Step {
  FitMatrix products;
  FitVector slopes;
  double chi2 = 0;
};

Step Evaluate(const SpotPatch& patch, const Weights& weights, const ModelMap& map,
              const FitVector& parameters) {
  const Eigen::Index rows = map.from.rows();
  RawVector raw = RawVector::Zero();
  raw.head(rows) = map.from * parameters;
  const NormalEquations sums = map.spots == 1   ? AccumulateFastest<1>(patch, weights, raw)
                               : map.spots == 2 ? AccumulateFastest<2>(patch, weights, raw)
                                                : AccumulateFastest<3>(patch, weights, raw);
  Step step;
  step.products = map.from.transpose() * sums.products.topLeftCorner(rows, rows).eval() * map.from;
  step.slopes = map.from.transpose() * sums.slopes.head(rows);
  step.chi2 = sums.chi2;
  return step;
}

/// Whether all Gaussians are of LED size and their middles in the patch.
bool IsSensible(const SpotPatch& patch, const ModelMap& map, const FitVector& parameters) {
  constexpr double kLeastPx2 = 0.3, kMostPx2 = 36;
  Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kRawMax, 1> raw = map.from * parameters;
  for (int k = 0; k < map.spots; ++k) {
    const auto of = raw.segment<kPerSpot>(kPerSpot * k);
    if (!(of[0] > 0 && of[1] >= 0 && of[1] <= 2 * patch.reach_x_px && of[2] >= 0 &&
          of[2] <= 2 * patch.reach_y_px && of[3] >= kLeastPx2 && of[3] <= kMostPx2))
      return false;
  }
  return true;
}

}  // namespace

std::optional<SpotFit> Fit(const SpotPatch& patch, SpotModel model, const FitVector& start,
                           const PixelLimits& pixels) {
  constexpr int kStepsMax = 20;
  constexpr double kConverged = 0.01;  // of the chi2 that one standard deviation makes: 0.1 of them at most
  constexpr double kFirstDamping = 1e-3, kMostDamping = 1e4, kDampingFactor = 10;
  const ModelMap map = MapOf(model);
  Weights weights;
  Weigh(patch, pixels, weights);
  FitVector at = start;
  if (!IsSensible(patch, map, at)) return std::nullopt;
  Step here = Evaluate(patch, weights, map, at);
  double damping = kFirstDamping;
  for (int i = 0; i < kStepsMax && damping < kMostDamping; ++i) {
    FitMatrix damped = here.products;
    damped.diagonal() *= 1 + damping;
    const Eigen::LDLT<FitMatrix> solver(damped);
    if (solver.info() != Eigen::Success || !solver.isPositive()) return std::nullopt;
    const FitVector by = solver.solve(here.slopes), next = at + by;
    const double promised = by.dot(here.slopes);
    const bool sensible = IsSensible(patch, map, next);
    const Step there = sensible ? Evaluate(patch, weights, map, next) : here;
    if (!sensible || !(there.chi2 < here.chi2 + kConverged)) {
      damping *= kDampingFactor;
      continue;
    }
    at = next, here = there;
    damping /= kDampingFactor;
    if (promised > kConverged) continue;
    const Eigen::LDLT<FitMatrix> inverse(here.products);
    if (inverse.info() != Eigen::Success || !inverse.isPositive()) return std::nullopt;
    const auto size = at.size();
    return SpotFit{at, inverse.solve(FitMatrix::Identity(size, size)), here.chi2,
                   weights.count - static_cast<int>(size), weights.energy};
  }
  return std::nullopt;
}

}  // namespace adit::detect
