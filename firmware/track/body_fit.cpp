#include "firmware/track/body_fit.h"

#include <Eigen/Geometry>
#include <cmath>

#include "firmware/base/rotation.h"
#include "firmware/base/symmetric.h"

namespace adit::track {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;
using Covariance5 = Eigen::Matrix<double, 5, 5>;

constexpr double kScaleSigma = 0.0025;  // stereo::LocatorOptions::scale / 2
constexpr double kTimesWorse = 3;       // centroids that are half a pixel's phase off, beside quiet ones
constexpr int kStepsMax = 10;
constexpr double kShortStep = 1e-10;  // m and rad: nothing that a bar shows

/// The covariance of where a bar is on its body, in the axes of b: of (centre, direction).
Matrix6d MountCovariance(const Body& body, const BodyBar& bar, const Vector3d& direction) {
  const double variance_m2 = body.sigma_m * body.sigma_m;
  Matrix6d covariance = Matrix6d::Zero();
  // The mean of two ends, and their difference over the length.
  covariance.topLeftCorner<3, 3>() = 0.5 * variance_m2 * Matrix3d::Identity();
  covariance.bottomRightCorner<3, 3>() = 2 * variance_m2 / (bar.length_m * bar.length_m) *
                                         (Matrix3d::Identity() - direction * direction.transpose());
  return covariance;
}

/// Where the bars' ends say the body is.
Placement Align(const Body& body, const SeenBars& seen) {
  Vector3d mean_b_m = Vector3d::Zero(), mean_t_m = Vector3d::Zero();
  double count = 0;
  for (std::size_t i = 0; i < body.bars.size(); ++i) {
    if (!seen[i]) continue;
    mean_b_m += seen[i]->point_b_m, mean_t_m += body.bars[i].CentreM(), count += 1;
  }
  mean_b_m /= count, mean_t_m /= count;
  Matrix3d spread = Matrix3d::Zero();
  for (std::size_t i = 0; i < body.bars.size(); ++i) {
    if (!seen[i]) continue;
    const BodyBar& bar = body.bars[i];
    // Both ends of a bar: twice its centre and twice half its length.
    spread += 2 * (seen[i]->point_b_m - mean_b_m) * (bar.CentreM() - mean_t_m).transpose();
    spread += 0.5 * bar.length_m * bar.length_m * seen[i]->direction_b * bar.direction_t.transpose();
  }
  Placement at;
  at.rotation = base::NearestRotation(spread);
  at.middle_b_m = mean_b_m + at.rotation * (body.MiddleM() - mean_t_m);
  return at;
}

/// Chi-square of `freedoms` that is exceeded once in a million (Wilson and Hilferty 1931).
double ChiSquareMax(int freedoms) {
  const double share = 2.0 / (9 * freedoms);
  return freedoms * std::pow(1 - share + 4.753 * std::sqrt(share), 3);
}

bool BarsFit(const Body& body, const SeenBars& seen, const Placement& at) {
  double chi_square = 0;
  int freedoms = -6;
  for (std::size_t i = 0; i < body.bars.size(); ++i) {
    if (!seen[i]) continue;
    const Difference difference = Compare(body, body.bars[i], *seen[i], at);
    Covariance5 wide = kTimesWorse * kTimesWorse * difference.covariance;
    const double scale_m = kScaleSigma * (body.bars[i].CentreM() - body.MiddleM()).norm();
    wide.diagonal().head<3>().array() += scale_m * scale_m;
    wide.diagonal().tail<2>().array() += kScaleSigma * kScaleSigma;
    chi_square += base::MahalanobisSquared(wide, difference.residual);
    freedoms += 5;
  }
  return chi_square <= ChiSquareMax(freedoms);  // a NaN does not fit
}

}  // namespace

Placement Stepped(const Placement& at, const Vector6d& step) {
  const Vector3d turn_rad = step.tail<3>();
  const double angle_rad = turn_rad.norm();
  Placement stepped{at.middle_b_m + step.head<3>(), at.rotation};
  if (angle_rad > 0)
    stepped.rotation = Eigen::AngleAxisd(angle_rad, turn_rad / angle_rad).toRotationMatrix() * at.rotation;
  return stepped;
}

ExpectedBar Expected(const Body& body, const BodyBar& bar, const Placement& at) {
  const Vector3d arm_b_m = at.rotation * (bar.CentreM() - body.MiddleM());
  const Vector3d direction = at.rotation * bar.direction_t;
  ExpectedBar expected;
  expected.place = {at.middle_b_m + arm_b_m, direction, MountCovariance(body, bar, direction)};
  expected.by_place.setZero();
  expected.by_place.topLeftCorner<3, 3>().setIdentity();
  expected.by_place.topRightCorner<3, 3>() = -base::Skew(arm_b_m);
  expected.by_place.bottomRightCorner<3, 3>() = -base::Skew(direction);
  return expected;
}

Difference Compare(const Body& body, const BodyBar& bar, const BarPlace& seen, const Placement& at) {
  const ExpectedBar expected = Expected(body, bar, at);
  const Vector3d& direction = expected.place.direction_b;
  Eigen::Matrix<double, 5, 6> across = Eigen::Matrix<double, 5, 6>::Zero();
  across.topLeftCorner<3, 3>().setIdentity();
  across.bottomRightCorner<2, 3>().row(0) = direction.unitOrthogonal();
  across.bottomRightCorner<2, 3>().row(1) = direction.cross(direction.unitOrthogonal());
  Vector6d both;
  both << seen.point_b_m - expected.place.point_b_m, seen.direction_b - direction;
  const Matrix6d covariance = seen.covariance + expected.place.covariance;
  return {across * both, across * expected.by_place, base::Congruence(across, covariance)};
}

BodyPose PoseOf(const Body& body, const Placement& at, const Matrix6d& covariance) {
  const Vector3d to_origin_b_m = -(at.rotation * body.MiddleM());
  return {{at.rotation, at.middle_b_m + to_origin_b_m}, MovedCovariance(covariance, to_origin_b_m)};
}

std::optional<BodyPose> FitBody(const Body& body, const SeenBars& seen) {
  int count = 0;
  for (std::size_t i = 0; i < body.bars.size(); ++i) count += seen[i] ? 1 : 0;
  if (count < 2) return std::nullopt;
  Placement at = Align(body, seen);
  Matrix6d information;
  for (int i = 0; i < kStepsMax; ++i) {
    information = Matrix6d::Zero();
    Vector6d gradient = Vector6d::Zero();
    for (std::size_t k = 0; k < body.bars.size(); ++k) {
      if (!seen[k]) continue;
      const Difference difference = Compare(body, body.bars[k], *seen[k], at);
      const Eigen::Matrix<double, 5, 6> weighted =
          base::SolveSymmetric(difference.covariance, difference.by_place);
      information += weighted.transpose() * difference.by_place;
      gradient += weighted.transpose() * difference.residual;
    }
    const Vector6d step = base::SolveSymmetric(information, gradient);
    if (!step.allFinite()) return std::nullopt;
    at = Stepped(at, step);
    if (step.norm() < kShortStep) break;
  }
  const Matrix6d covariance = base::InverseSymmetric(information);
  const double turn_variance = covariance.bottomRightCorner<3, 3>().trace();
  // Written so that NaN declines.
  if (!(covariance.allFinite() && turn_variance <= kTurnSigmaMaxRad * kTurnSigmaMaxRad)) return std::nullopt;
  if (!BarsFit(body, seen, at)) return std::nullopt;
  return PoseOf(body, at, covariance);
}

}  // namespace adit::track
