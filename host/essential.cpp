#include "host/essential.h"

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "host/normal_matrix.h"

namespace adit::host {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr std::size_t kPointsMin = 8;
constexpr double kRankTolerance = 1e-10;  // of the design matrix's largest singular value
constexpr double kParallelRad = 1e-6;     // at 110 m from a 9 m base rays meet at 0.08 rad
constexpr double kInFrontMin = 0.9;       // share of points; noise and wrong pairs spoil a few

/// Moves the points' mean to 0 and their mean distance to sqrt 2: without it the columns of the design matrix
/// differ by orders of magnitude and the smallest singular vector is noise (Hartley 1997).
Matrix3d Normaliser(std::span<const RayPair> points, Vector2d RayPair::*side) {
  Vector2d mean = Vector2d::Zero();
  for (const RayPair& p : points) mean += p.*side;
  mean /= static_cast<double>(points.size());
  double distance = 0;
  for (const RayPair& p : points) distance += (p.*side - mean).norm();
  distance /= static_cast<double>(points.size());
  const double scale = distance > 0 ? std::sqrt(2.0) / distance : 1.0;
  Matrix3d normaliser;
  normaliser << scale, 0, -scale * mean.x(), 0, scale, -scale * mean.y(), 0, 0, 1;
  return normaliser;
}

}  // namespace

std::optional<Matrix3d> EssentialFromPoints(std::span<const RayPair> points) {
  if (points.size() < kPointsMin) return std::nullopt;
  const Matrix3d to_left = Normaliser(points, &RayPair::left);
  const Matrix3d to_right = Normaliser(points, &RayPair::right);
  // At least 9 rows, so that the thin V still holds the null vector of 8 points.
  const auto rows = static_cast<Eigen::Index>(std::max<std::size_t>(points.size(), 9));
  Eigen::Matrix<double, Eigen::Dynamic, 9> design = Eigen::Matrix<double, Eigen::Dynamic, 9>::Zero(rows, 9);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector3d l = to_left * points[i].left.homogeneous();
    const Vector3d r = to_right * points[i].right.homogeneous();
    design.row(static_cast<Eigen::Index>(i)) << (r.x() * l).transpose(), (r.y() * l).transpose(),
        (r.z() * l).transpose();
  }
  const SingularValues solution = SingularValuesOf(design);
  if (solution.values[7] < kRankTolerance * solution.values[0]) return std::nullopt;
  const Eigen::Matrix<double, 9, 1> null = solution.right.col(8);
  const Matrix3d normalised =
      (Matrix3d() << null.head<3>().transpose(), null.segment<3>(3).transpose(), null.tail<3>().transpose())
          .finished();
  const Matrix3d raw = to_right.transpose() * normalised * to_left;
  const Eigen::JacobiSVD<Matrix3d> svd(raw, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return svd.matrixU() * Vector3d(1, 1, 0).asDiagonal() * svd.matrixV().transpose();
}

double SampsonSquared(const Matrix3d& essential, const RayPair& pair) {
  const Vector3d line_right = essential * pair.left.homogeneous();
  const Vector3d line_left = essential.transpose() * pair.right.homogeneous();
  const double miss = pair.right.homogeneous().dot(line_right);
  const double slope2 = line_right.head<2>().squaredNorm() + line_left.head<2>().squaredNorm();
  return slope2 > 0 ? miss * miss / slope2 : 0.0;
}

std::array<RelativePose, 4> DecomposeEssential(const Matrix3d& essential) {
  const Eigen::JacobiSVD<Matrix3d> svd(essential, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Matrix3d& u = svd.matrixU();
  const Matrix3d& v = svd.matrixV();
  Matrix3d w;
  w << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  // E is known up to its sign, so the sign that makes both rotations proper is free to choose.
  const auto proper = [](const Matrix3d& m) { return Matrix3d(m.determinant() < 0 ? Matrix3d(-m) : m); };
  const Matrix3d first = proper(u * w * v.transpose());
  const Matrix3d second = proper(u * w.transpose() * v.transpose());
  const Vector3d t = u.col(2);
  return {{{first, t}, {first, -t}, {second, t}, {second, -t}}};
}

std::optional<Triangulated> Triangulate(const RelativePose& T_r_l, const RayPair& pair) {
  // depth_right * r - depth_left * R l = t, by least squares over the two depths.
  const Vector3d l = T_r_l.rotation * pair.left.homogeneous();
  const Vector3d r = pair.right.homogeneous();
  const Vector3d t = T_r_l.translation_m;
  const double ll = l.squaredNorm(), rr = r.squaredNorm(), lr = l.dot(r);
  const double det = ll * rr - lr * lr;  // = |l|^2 |r|^2 sin^2 of the angle
  if (!(det > kParallelRad * kParallelRad * ll * rr)) return std::nullopt;
  const double depth_left = (lr * r.dot(t) - rr * l.dot(t)) / det;
  const double depth_right = (ll * r.dot(t) - lr * l.dot(t)) / det;
  const Vector3d middle_r = 0.5 * (depth_left * l + t + depth_right * r);
  return Triangulated{T_r_l.Inverse() * middle_r, depth_left, depth_right};
}

std::optional<RelativePose> ChoosePose(const Matrix3d& essential, std::span<const RayPair> points) {
  std::size_t best_count = 0;
  RelativePose best;
  for (const RelativePose& pose : DecomposeEssential(essential)) {
    std::size_t count = 0;
    for (const RayPair& p : points) {
      const auto point = Triangulate(pose, p);
      if (point && point->depth_left > 0 && point->depth_right > 0) ++count;
    }
    if (count > best_count) best_count = count, best = pose;
  }
  if (static_cast<double>(best_count) < kInFrontMin * static_cast<double>(points.size()) || points.empty())
    return std::nullopt;
  return best;
}

}  // namespace adit::host
