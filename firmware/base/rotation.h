// Rotations from sums of vectors.
#pragma once

#include <Eigen/Core>

namespace adit::base {

/// The rotation R with the largest trace of Rᵀ m: the one that takes the a_i nearest to the b_i, least
/// squares, for m = sum b_i a_iᵀ (Umeyama 1991, equations 34 to 42, unweighted). Not determined where the a_i
/// lie on one line.
Eigen::Matrix3d NearestRotation(const Eigen::Matrix3d& m);

}  // namespace adit::base
