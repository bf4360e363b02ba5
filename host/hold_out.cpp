#include "host/hold_out.h"

#include <Eigen/LU>
#include <array>
#include <cmath>

#include "firmware/base/symmetric.h"
#include "host/bundle_costs.h"
#include "host/rig_uncertainty.h"

namespace adit::host {
namespace {

constexpr double kChi2Max = 31.3;  // 99.9 % of 11 degrees of freedom: 16 residuals, 5 parameters
constexpr int kPlaceStepsMax = 20;

RawPair PairOf(const StereoBar& bar, std::size_t led) {
  return {bar.left[led].raw_px, bar.right[led].raw_px};
}

/// The covariance of an LED's raw pixels in both images.
Eigen::Matrix4d RawCovariance(const BundleSetting& setting, const StereoBar& bar, std::size_t led) {
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();
  const Eigen::Matrix2d left = WhitenedView(bar.left[led], setting.left, setting.noise_scale).whiten,
                        right = WhitenedView(bar.right[led], setting.right, setting.noise_scale).whiten;
  covariance.topLeftCorner<2, 2>() = (left.transpose() * left).inverse();
  covariance.bottomRightCorner<2, 2>() = (right.transpose() * right).inverse();
  return covariance;
}

/// LED 1 to LED 4 as measured, each end triangulated on its own, and one standard deviation of it from the
/// centroids and the calibration.
struct MeasuredLength {
  double length_m = 0, sigma_m = 0;
};

std::optional<MeasuredLength> Measure(const BundleSetting& setting, const optics::Rig& rig,
                                      const optics::RigCovariance& covariance, const StereoBar& bar) {
  constexpr std::size_t kLast = base::kLedCount - 1;
  const auto first = Locate(rig, PairOf(bar, 0)), last = Locate(rig, PairOf(bar, kLast));
  const auto by_first = DerivativesOf(rig, PairOf(bar, 0)), by_last = DerivativesOf(rig, PairOf(bar, kLast));
  if (!first || !last || !by_first || !by_last) return std::nullopt;
  const Eigen::RowVector3d along = (*last - *first).normalized().transpose();
  const Eigen::Matrix<double, 1, optics::kRigParameters> by_rig =
      along * (by_last->by_rig - by_first->by_rig);
  const Eigen::RowVector4d by_p = along * by_first->by_pixel, by_q = along * by_last->by_pixel;
  const double variance = (by_rig * covariance).dot(by_rig) +
                          (by_p * RawCovariance(setting, bar, 0)).dot(by_p) +
                          (by_q * RawCovariance(setting, bar, kLast)).dot(by_q);
  return MeasuredLength{(*last - *first).norm(), std::sqrt(variance)};
}

}  // namespace

double HoldOut::RatioMax() const {
  // chi2 / n is about (1 - 2/9n + z sqrt(2/9n))^3; z = 3.09 at one in a thousand.
  const double part = 2 / (9 * static_cast<double>(bars.size()));
  return bars.empty() ? 0 : std::pow(1 - part + 3.09 * std::sqrt(part), 1.5);
}

std::optional<StereoBar> Undistorted(const StereoBar& bar, const optics::Rig& rig) {
  StereoBar out = bar;
  for (std::size_t i = 0; i < base::kLedCount; ++i) {
    const auto left = rig.left.Undistort(bar.left[i].raw_px),
               right = rig.right.Undistort(bar.right[i].raw_px);
    if (!left || !right) return std::nullopt;
    out.left[i].ideal_px = *left, out.right[i].ideal_px = *right;
  }
  return out;
}

std::optional<FittedBar> FitBar(const BundleSetting& setting, const optics::Rig& rig, const StereoBar& bar) {
  const auto undistorted = Undistorted(bar, rig);
  if (!undistorted) return std::nullopt;
  const auto start = PlaceBar(rig, *undistorted, setting.targets[bar.target]);
  if (!start) return std::nullopt;
  BundleSetting fixed = setting;
  fixed.left = rig.left, fixed.right = rig.right;
  const BarCost cost({&fixed, rig.T_r_l.rotation}, bar, start->direction_l);
  const Eigen::Vector3d &c = start->centre_l_m, &t = rig.T_r_l.translation_m;
  const std::array<double, kPoseSize> pose{0, 0, 0, t.x(), t.y(), t.z()};
  const std::array<double, kIntrinsics> zero{};
  Eigen::Matrix<double, kBarSize, 1> at;
  at << c, 0, 0;
  Eigen::Matrix<double, kBarResiduals, 1> residual;
  Eigen::Matrix<double, kBarResiduals, kBarSize, Eigen::RowMajor> jacobian;
  const std::array<const double*, 5> parameters{pose.data(), zero.data(), zero.data(), zero.data(),
                                                at.data()};
  std::array<double*, 5> jacobians{nullptr, nullptr, nullptr, nullptr, jacobian.data()};
  // Gauss-Newton: the start is within noise of the end.
  for (int i = 0; i < kPlaceStepsMax; ++i) {
    if (!cost.Evaluate(parameters.data(), residual.data(), jacobians.data())) return std::nullopt;
    const Eigen::Matrix<double, kBarSize, kBarSize> normal = jacobian.transpose() * jacobian;
    const Eigen::Matrix<double, kBarSize, 1> gradient = jacobian.transpose() * residual;
    const Eigen::Matrix<double, kBarSize, 1> step = base::SolveSymmetric(normal, gradient);
    at -= step;
    if ((jacobian * step).squaredNorm() < 1e-10) break;
  }
  if (!cost.Evaluate(parameters.data(), residual.data(), nullptr)) return std::nullopt;
  return FittedBar{{at.head<3>(), cost.Chart().Direction(at.data() + 3)}, residual.squaredNorm()};
}

HoldOut TestHoldOut(const BundleSetting& setting, const optics::Rig& rig,
                    const optics::RigCovariance& covariance, std::span<const StereoBar> bars) {
  HoldOut out;
  double chi2 = 0, errors_m2 = 0, predicted_m2 = 0, ratios = 0;
  for (const StereoBar& bar : bars) {
    const auto fitted = FitBar(setting, rig, bar);
    if (!fitted || !(fitted->chi2 < kChi2Max)) {
      out.misfits.push_back(bar);
      continue;
    }
    const auto measured = Measure(setting, rig, covariance, bar);
    if (!measured) continue;
    const double error_m = measured->length_m - setting.targets[bar.target].LengthM();
    out.bars.push_back({KeyOf(bar), fitted->place.centre_l_m.norm(), error_m, measured->sigma_m});
    chi2 += fitted->chi2;
    errors_m2 += error_m * error_m;
    predicted_m2 += measured->sigma_m * measured->sigma_m;
    ratios += error_m * error_m / (measured->sigma_m * measured->sigma_m);
  }
  if (out.bars.empty()) return out;
  const auto count = static_cast<double>(out.bars.size());
  out.error_m = std::sqrt(errors_m2 / count);
  out.predicted_m = std::sqrt(predicted_m2 / count);
  out.ratio = std::sqrt(ratios / count);
  constexpr double kFreedom = kBarResiduals - kBarSize;
  out.reprojection = std::sqrt(chi2 / (kFreedom * count));
  return out;
}

}  // namespace adit::host
