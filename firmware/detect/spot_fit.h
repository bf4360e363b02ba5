// The pixels around a bright region as Gaussians of one width on an even background: least squares, every
// pixel weighted with its noise, clipped ones left out.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "firmware/detect/centroid.h"
#include "firmware/detect/spot_patch.h"

namespace adit::detect {

/// What a bright region may be.
enum class SpotModel : std::uint8_t {
  kOne,      ///< a round LED
  kSmeared,  ///< an LED that moved straight and evenly during the exposure
  kTwo,      ///< two round LEDs of one width
};

/// The parameters of each model, in this order: kOne height, x, y; kSmeared height, x, y, movement x, y; kTwo
/// height, x, y, and again. Then the square of the width and the background. DN above the patch's background,
/// pixels from the patch's first one.
inline constexpr int kFitParametersMax = 8;
using FitVector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kFitParametersMax, 1>;
using FitMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kFitParametersMax,
                                kFitParametersMax>;

struct SpotFit {
  FitVector parameters;
  FitMatrix covariance;
  double chi2 = 0;  ///< sum of the squared residuals over the pixels' variances
  int freedoms = 0;
  double energy = 0;  ///< sum of the squared light over the pixels' variances
};

/// What the pixels are.
struct PixelLimits {
  PixelNoise noise;
  double full_dn = 255;  ///< where they clip
};

/// The parameters that fit best, sought from `start` by Levenberg's and Marquardt's method. None where that
/// ends nowhere sensible.
std::optional<SpotFit> Fit(const SpotPatch& patch, SpotModel model, const FitVector& start,
                           const PixelLimits& pixels);

}  // namespace adit::detect
