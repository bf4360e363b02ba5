#include "firmware/track/bar_filter.h"

#include <Eigen/Geometry>
#include <cmath>

#include "firmware/base/symmetric.h"
#include "firmware/track/joseph_update.h"
#include "firmware/track/white_acceleration.h"

namespace adit::track {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

// Below what any camera resolves; keeps covariances invertible that claim to know everything.
constexpr double kNoiseMinM = 1e-6, kNoiseMinRad = 1e-6;
// cos 60 degrees: where a tangent plane says little about the direction.
constexpr double kSameWay = 0.5;

// Where the parameters stand: what is measured leads.
constexpr int kPoint = 0, kAside = 3, kSpeed = 5, kAsideRate = 8, kMeasured = 5;

}  // namespace

BarFilter::BarFilter(const MotionOptions& options, base::TimeNs exposure_ns, const BarPlace& measured)
    : options_(options), exposure_ns_(exposure_ns), point_b_m_(measured.point_b_m) {
  basis_.col(0) = measured.direction_b.normalized();
  basis_.col(1) = basis_.col(0).unitOrthogonal();
  basis_.col(2) = basis_.col(0).cross(basis_.col(1));
  covariance_.topLeftCorner<kMeasured, kMeasured>() = NoiseOf(measured);
  covariance_.diagonal().segment<3>(kSpeed).setConstant(options.speed_m_per_s * options.speed_m_per_s);
  covariance_.diagonal().segment<2>(kAsideRate).setConstant(options.rate_rad_per_s * options.rate_rad_per_s);
}

void BarFilter::Advance(base::TimeNs exposure_ns) {
  if (exposure_ns <= exposure_ns_) return;
  const double dt_s = static_cast<double>(exposure_ns - exposure_ns_) / static_cast<double>(base::kNsPerS);
  exposure_ns_ = exposure_ns;
  point_b_m_ += dt_s * velocity_m_per_s_;
  // Along a great circle the rate's components stay what they are in the basis that is carried along.
  Turn(dt_s * rate_rad_per_s_);
  CarryOver(covariance_, {kPoint, kSpeed, 3}, options_.acceleration_m_per_s2_per_sqrt_hz, dt_s);
  CarryOver(covariance_, {kAside, kAsideRate, 2}, options_.turning_rad_per_s2_per_sqrt_hz, dt_s);
}

std::optional<BarFilter::Innovation> BarFilter::InnovationOf(const BarPlace& measured) const {
  const double cosine = basis_.col(0).dot(measured.direction_b);
  // Written so that NaN does not pass.
  if (!(cosine > kSameWay) || !measured.point_b_m.allFinite() || !measured.covariance.allFinite())
    return std::nullopt;
  const Vector2d sine = Tangent().transpose() * measured.direction_b;
  const double angle_rad = std::atan2(sine.norm(), cosine);
  Innovation innovation;
  innovation.head<3>() = measured.point_b_m - point_b_m_;
  innovation.tail<2>() = sine.norm() > 0 ? Vector2d(sine * (angle_rad / sine.norm())) : sine;
  return innovation;
}

BarFilter::InnovationCovariance BarFilter::NoiseOf(const BarPlace& measured) const {
  InnovationCovariance noise;
  noise.topLeftCorner<3, 3>() = measured.covariance.topLeftCorner<3, 3>();
  noise.topRightCorner<3, 2>() = measured.covariance.topRightCorner<3, 3>() * Tangent();
  noise.bottomLeftCorner<2, 3>() = noise.topRightCorner<3, 2>().transpose();
  noise.bottomRightCorner<2, 2>() =
      Tangent().transpose() * measured.covariance.bottomRightCorner<3, 3>() * Tangent();
  noise.diagonal().head<3>().array() += kNoiseMinM * kNoiseMinM;
  noise.diagonal().tail<2>().array() += kNoiseMinRad * kNoiseMinRad;
  return noise;
}

std::optional<double> BarFilter::ChiSquare(const BarPlace& measured) const {
  const auto innovation = InnovationOf(measured);
  if (!innovation) return std::nullopt;
  const InnovationCovariance s = covariance_.topLeftCorner<kMeasured, kMeasured>() + NoiseOf(measured);
  const double chi_square = base::MahalanobisSquared(s, *innovation);
  if (!std::isfinite(chi_square)) return std::nullopt;
  return chi_square;
}

void BarFilter::Update(const BarPlace& measured) {
  const auto innovation = InnovationOf(measured);
  ADIT_REQUIRE(innovation.has_value());
  const InnovationCovariance h = InnovationCovariance::Identity();
  const Eigen::Matrix<double, 10, 1> step = TakeIn(h, NoiseOf(measured), *innovation, covariance_);
  point_b_m_ += step.segment<3>(kPoint);
  velocity_m_per_s_ += step.segment<3>(kSpeed);
  rate_rad_per_s_ += step.segment<2>(kAsideRate);
  Turn(step.segment<2>(kAside));
}

/// Takes the basis along the great circle by `step_rad`.
void BarFilter::Turn(const Vector2d& step_rad) {
  const double angle_rad = step_rad.norm();
  if (!(angle_rad > 0)) return;
  const Vector3d axis = basis_.col(0).cross(Vector3d(Tangent() * step_rad)) / angle_rad;
  basis_ = Eigen::AngleAxisd(angle_rad, axis).toRotationMatrix() * basis_;
  // Rounding would let the basis shear over a day of frames.
  basis_.col(0).normalize();
  basis_.col(1) = (basis_.col(1) - basis_.col(0).dot(basis_.col(1)) * basis_.col(0)).normalized();
  basis_.col(2) = basis_.col(0).cross(basis_.col(1));
}

BarPlace BarFilter::Place() const {
  BarPlace place{point_b_m_, basis_.col(0), {}};
  const Eigen::Matrix<double, 3, 2> tangent = Tangent();
  const Eigen::Matrix<double, 3, 3> across = covariance_.block<3, 2>(kPoint, kAside) * tangent.transpose();
  place.covariance << covariance_.block<3, 3>(kPoint, kPoint), across, across.transpose(),
      tangent * covariance_.block<2, 2>(kAside, kAside) * tangent.transpose();
  return place;
}

}  // namespace adit::track
