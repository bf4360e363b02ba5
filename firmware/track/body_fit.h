// Bars of a body -> the body's pose.
#pragma once

#include <array>
#include <optional>

#include "firmware/track/bar_place.h"
#include "firmware/track/body.h"
#include "firmware/track/body_pose.h"

namespace adit::track {

/// The bars of a body that are seen, each by its centre, in the order of Body::bars.
using SeenBars = std::array<std::optional<BarPlace>, kMaxBodyBars>;

/// A body's place by the middle of its bars (Body::MiddleM).
struct Placement {
  Eigen::Vector3d middle_b_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  ///< R_b_t
};

/// `at` after a step of (middle: m, small rotation in the axes of b: rad).
Placement Stepped(const Placement& at, const Eigen::Matrix<double, 6, 1>& step);

/// Where one bar must be, by its centre; the covariance is that of its place on the body.
struct ExpectedBar {
  BarPlace place;
  Eigen::Matrix<double, 6, 6> by_place;  ///< derivative of (centre, direction) by a step
};
ExpectedBar Expected(const Body& body, const BodyBar& bar, const Placement& at);

/// One seen bar against where it must be.
struct Difference {
  Eigen::Matrix<double, 5, 1> residual;  ///< seen minus expected: centre, and direction across it
  Eigen::Matrix<double, 5, 6> by_place;  ///< derivative of what is expected by a step
  Eigen::Matrix<double, 5, 5> covariance;
};
Difference Compare(const Body& body, const BodyBar& bar, const BarPlace& seen, const Placement& at);

/// The pose by the body's origin. `covariance` is that of a step from `at`.
BodyPose PoseOf(const Body& body, const Placement& at, const Eigen::Matrix<double, 6, 6>& covariance);

/// The pose that fits centres and directions of all seen bars best, weighted by their covariances and by
/// Body::sigma_m: 6 parameters, Gauss-Newton from the absolute orientation of the bars' ends (Kabsch 1976).
/// Declines less than two bars, bars that show too little of a turn (more than 0.1 rad of standard
/// deviation), and bars that do not fit the body: by their chi-square after allowing that measurements are
/// three times worse than they say and distances wrong by what a calibration in use may be off (0.25 %, 1
/// sigma, as the stereo stage).
std::optional<BodyPose> FitBody(const Body& body, const SeenBars& seen);

}  // namespace adit::track
