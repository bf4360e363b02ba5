#include "firmware/base/yaml_pose.h"

#include <Eigen/LU>
#include <sstream>

#include "firmware/base/symmetric.h"

namespace adit::base {
namespace {

constexpr double kOrthonormalTolerance = 1e-6;  // a file of 9 digits keeps rotations this well

}  // namespace

void ReadRigidMotion(YamlReader& in, const std::string& key, Eigen::Matrix3d& rotation,
                     Eigen::Vector3d& translation_m) {
  const auto rows = in.Matrix(key, 4, 4);
  if (!in.Ok()) return;
  if (!(rows[12] == 0 && rows[13] == 0 && rows[14] == 0 && rows[15] == 1))
    return in.Refuse(key + "[3]", "is not [0, 0, 0, 1]");
  const Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>> motion(rows.data());
  const Eigen::Matrix3d block = motion.topLeftCorner<3, 3>();
  const double miss = (block * block.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!(miss <= kOrthonormalTolerance)) {
    std::ostringstream text;
    text << "has no rotation in its upper left 3 x 3 block: R R^T differs from 1 by " << miss << "; at most "
         << kOrthonormalTolerance << " is allowed";
    return in.Refuse(key, text.str());
  }
  if (block.determinant() < 0) {
    return in.Refuse(key,
                     "has a mirror in its upper left 3 x 3 block (determinant -1); it must be a rotation");
  }
  rotation = block;
  translation_m = motion.topRightCorner<3, 1>();
}

void ReadCovariance(YamlReader& in, const std::string& key, Eigen::Matrix<double, 6, 6>& covariance) {
  const auto rows = in.Matrix(key, 6, 6);
  if (!in.Ok()) return;
  covariance = Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(rows.data());
  constexpr double kRounding = 1e-9;  // relative; a covariance of 17 digits is symmetric this well
  const double rounding = kRounding * covariance.cwiseAbs().maxCoeff();
  if ((covariance - covariance.transpose()).cwiseAbs().maxCoeff() > rounding)
    return in.Refuse(key, "is not symmetric");
  if (!IsSemidefinite(covariance, rounding))
    in.Refuse(key, "gives some combination of its parameters a negative variance");
}

}  // namespace adit::base
