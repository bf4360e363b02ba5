#include "host/intrinsic_prior.h"

#include <algorithm>
#include <cmath>

#include "firmware/base/yaml.h"
#include "host/normal_matrix.h"

namespace adit::host {
namespace {

using CovarianceRows = Eigen::Map<const Eigen::Matrix<double, kIntrinsics, kIntrinsics, Eigen::RowMajor>>;

/// Its standard deviations, zero where the diagonal is.
IntrinsicVector Deviations(const IntrinsicMatrix& covariance) {
  return covariance.diagonal().cwiseMax(0).cwiseSqrt();
}

/// Eigenvectors and eigenvalues of the correlations: the variances differ by ten orders of magnitude.
Spectrum Correlations(const IntrinsicMatrix& covariance) {
  IntrinsicVector inverse = Deviations(covariance);
  for (double& value : inverse) value = value > 0 ? 1 / value : 0;
  return SpectrumOf(inverse.asDiagonal() * covariance * inverse.asDiagonal());
}

}  // namespace

IntrinsicVector IntrinsicPrior::Steps(const IntrinsicVector& mean, const IntrinsicVector& now) const {
  // Rows in units of their sigma: a focal length in pixels must not drown k2.
  IntrinsicVector unit = root.rowwise().norm();
  for (double& value : unit) value = value > 0 ? 1 / value : 0;
  return ShortestSolution(unit.asDiagonal() * root, unit.cwiseProduct(now - mean));
}

IntrinsicPrior PriorOf(const IntrinsicSigmas& sigmas, const optics::CameraModel& camera) {
  const double u = std::max(camera.cu_px, camera.width_px - camera.cu_px),
               v = std::max(camera.cv_px, camera.height_px - camera.cv_px);
  const double radius = std::hypot(u / camera.fu_px, v / camera.fv_px);
  IntrinsicPrior prior;
  prior.root(0, 0) = camera.fu_px * sigmas.focal_pct / 100;
  prior.root(1, 0) = camera.fv_px * sigmas.focal_pct / 100;
  prior.root(2, 2) = prior.root(3, 3) = sigmas.centre_px;
  prior.root(4, 4) = sigmas.distortion_px / (camera.fu_px * std::pow(radius, 3));
  return prior;
}

IntrinsicPrior PriorOf(const IntrinsicMatrix& covariance) {
  const auto eigen = Correlations(covariance);
  IntrinsicPrior prior;
  prior.root =
      Deviations(covariance).asDiagonal() * eigen.vectors * eigen.values.cwiseMax(0).cwiseSqrt().asDiagonal();
  prior.is_measured = true;
  return prior;
}

base::Result<IntrinsicPrior> LoadPrior(const std::string& path, const IntrinsicSigmas& sigmas,
                                       const optics::CameraModel& camera) {
  auto in = base::YamlReader::OpenFile(path);
  if (!in) return in.error();
  const char* const key = "covariance";
  if (!in->Has(key)) return PriorOf(sigmas, camera);
  const auto values = in->Matrix(key, kIntrinsics, kIntrinsics);
  for (const std::string& other : in->Keys()) in->Ignore(other);
  IntrinsicMatrix covariance = IntrinsicMatrix::Zero();
  if (in->Ok()) {
    covariance = CovarianceRows(values.data());
    const IntrinsicVector sigma = Deviations(covariance);
    const IntrinsicMatrix skew = covariance - covariance.transpose();
    constexpr double kRounding = 1e-6;  // nine digits are written
    if (!(skew.cwiseAbs().array() <= kRounding * (sigma * sigma.transpose()).array()).all() ||
        !(covariance.diagonal().minCoeff() >= 0) ||
        !(Correlations(covariance).values.minCoeff() >= -kRounding)) {
      in->Refuse(key, "is no covariance: it must be symmetric, without negative variances");
    }
  }
  if (auto done = in->Finish(); !done) return done.error();
  return PriorOf(covariance);
}

}  // namespace adit::host
