#include "firmware/track/body_filter.h"

#include "firmware/base/symmetric.h"
#include "firmware/track/joseph_update.h"
#include "firmware/track/white_acceleration.h"

namespace adit::track {

using Eigen::Vector3d;

namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

// Where the parameters stand: the placement leads.
constexpr int kMiddle = 0, kTheta = 3, kVelocity = 6, kRate = 9, kPlacement = 6;

/// Of a step, by shaking alone.
Matrix6d Shaking(const MotionOptions& motion) {
  Matrix6d shaking = Matrix6d::Zero();
  shaking.diagonal().tail<3>().setConstant(motion.body_shake_rad * motion.body_shake_rad);
  return shaking;
}

}  // namespace

BodyFilter::BodyFilter(const MotionOptions& motion, base::TimeNs exposure_ns, const Body& body,
                       const BodyPose& pose)
    : motion_(motion), exposure_ns_(exposure_ns), at_{pose.T_b_t * body.MiddleM(), pose.T_b_t.rotation} {
  const Matrix6d of_middle = MovedCovariance(pose.covariance, pose.T_b_t.rotation * body.MiddleM());
  covariance_.topLeftCorner<kPlacement, kPlacement>() = of_middle + Shaking(motion);
  covariance_.diagonal().segment<3>(kVelocity).setConstant(motion.speed_m_per_s * motion.speed_m_per_s);
  covariance_.diagonal().segment<3>(kRate).setConstant(motion.rate_rad_per_s * motion.rate_rad_per_s);
}

void BodyFilter::Advance(base::TimeNs exposure_ns) {
  if (exposure_ns <= exposure_ns_) return;
  const double dt_s = static_cast<double>(exposure_ns - exposure_ns_) / static_cast<double>(base::kNsPerS);
  exposure_ns_ = exposure_ns;
  Vector6d step;
  step << velocity_m_per_s_, rate_rad_per_s_;
  const Placement before = at_;
  at_ = Stepped(at_, dt_s * step);
  // What is not known of the rotation turns with the body, or a bar that is seen from all sides in the course
  // of a turn would seem to show the turn around itself.
  const Eigen::Matrix3d turn = at_.rotation * before.rotation.transpose();
  covariance_.middleRows<3>(kTheta) = (turn * covariance_.middleRows<3>(kTheta)).eval();
  covariance_.middleCols<3>(kTheta) = (covariance_.middleCols<3>(kTheta) * turn.transpose()).eval();
  CarryOver(covariance_, {kMiddle, kVelocity, 3}, motion_.acceleration_m_per_s2_per_sqrt_hz, dt_s);
  CarryOver(covariance_, {kTheta, kRate, 3}, motion_.body_turning_rad_per_s2_per_sqrt_hz, dt_s);
}

bool BodyFilter::Take(const Body& body, const BodyBar& bar, const BarPlace& seen) {
  const Difference difference = Compare(body, bar, seen, at_);
  const Eigen::Matrix<double, 5, kPlacement>& h = difference.by_place;
  const Eigen::Matrix<double, 5, 5> noise = difference.covariance + base::Congruence(h, Shaking(motion_));
  const Eigen::Matrix<double, 5, 5> s =
      base::Congruence(h, Matrix6d(covariance_.topLeftCorner<kPlacement, kPlacement>())) + noise;
  // Written so that NaN does not pass.
  if (!(base::MahalanobisSquared(s, difference.residual) <= motion_.chi_square_max)) return false;
  const Eigen::Matrix<double, 12, 1> step = TakeIn(h, noise, difference.residual, covariance_);
  at_ = Stepped(at_, step.head<kPlacement>());
  velocity_m_per_s_ += step.segment<3>(kVelocity);
  rate_rad_per_s_ += step.segment<3>(kRate);
  return true;
}

/// Of what shakes and what does not.
Matrix6d BodyFilter::PlacementCovariance() const {
  return covariance_.topLeftCorner<kPlacement, kPlacement>() + Shaking(motion_);
}

BodyPose BodyFilter::Pose(const Body& body) const { return PoseOf(body, at_, PlacementCovariance()); }

BarPlace BodyFilter::PlaceOf(const Body& body, const BodyBar& bar) const {
  const ExpectedBar expected = Expected(body, bar, at_);
  BarPlace place = expected.place;
  place.covariance += base::Congruence(expected.by_place, PlacementCovariance());
  return place;
}

}  // namespace adit::track
