// A camera's parameters as a vector.
#pragma once

#include <Eigen/Core>
#include <array>

#include "firmware/optics/camera_model.h"

namespace adit::host {

constexpr int kIntrinsics = 8;
/// Their order wherever they stand in a row: files, covariance, tables. fu, fv, cu, cv are in pixels.
constexpr std::array<const char*, kIntrinsics> kIntrinsicNames{"fu", "fv", "cu", "cv",
                                                               "k1", "k2", "p1", "p2"};
using IntrinsicVector = Eigen::Matrix<double, kIntrinsics, 1>;
using IntrinsicMatrix = Eigen::Matrix<double, kIntrinsics, kIntrinsics>;

IntrinsicVector Intrinsics(const optics::CameraModel& camera);
/// A camera with these parameters and the image size of `size`.
optics::CameraModel CameraOf(const IntrinsicVector& intrinsics, const optics::CameraModel& size);

}  // namespace adit::host
