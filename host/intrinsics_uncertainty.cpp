#include "host/intrinsics_uncertainty.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iomanip>
#include <sstream>

#include "host/normal_matrix.h"

namespace adit::host {
namespace {

constexpr double kUndeterminedPct = 1;  // of half the diagonal, at the image's corner
constexpr double kUncertainPx = 1;      // the same in pixels, for a warning
constexpr double kChanceSigma = 3;
constexpr double kVarianceSigma =
    0.95;  // of the estimated variance times sqrt(images), by simulation for 5 to 40

std::string Tenths(double value) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(1) << value;
  return text.str();
}

/// d raw pixel / d intrinsics for the ray to the image's corner that is farthest from the principal point.
Eigen::Matrix<double, 2, kIntrinsics> AtImageCorner(const optics::CameraModel& c) {
  const double u = c.cu_px < c.width_px / 2.0 ? c.width_px : 0,
               v = c.cv_px < c.height_px / 2.0 ? c.height_px : 0;
  const Eigen::Vector2d n = c.Normalised({u, v});
  const double x = n.x(), y = n.y(), r2 = n.squaredNorm();
  Eigen::Matrix<double, 2, kIntrinsics> jacobian;
  jacobian << x, 0, 1, 0, c.fu_px * x * r2, c.fu_px * x * r2 * r2, c.fu_px * 2 * x * y,
      c.fu_px * (r2 + 2 * x * x), 0, y, 0, 1, c.fv_px * y * r2, c.fv_px * y * r2 * r2,
      c.fv_px * (r2 + 2 * y * y), c.fv_px * 2 * x * y;
  return jacobian;
}

/// The inverse of an information matrix, judged in units of the image corner's movement.
IntrinsicMatrix Inverse(const IntrinsicMatrix& information, const optics::CameraModel& camera) {
  const IntrinsicVector unit = AtImageCorner(camera).colwise().norm().cwiseInverse();
  const Spectrum eigen = SpectrumOf(unit.asDiagonal() * information * unit.asDiagonal());
  constexpr double kRounding = 1e-14;
  const IntrinsicVector values = eigen.values.cwiseMax(kRounding * eigen.values[kIntrinsics - 1]);
  return unit.asDiagonal() * eigen.vectors * values.cwiseInverse().asDiagonal() * eigen.vectors.transpose() *
         unit.asDiagonal();
}

/// Parameters that act as one, and what makes images that determine them.
struct IntrinsicPair {
  int first;
  const char *name, *remedy;
};
constexpr std::array<IntrinsicPair, 4> kPairs{{
    {0, "focal length (fu, fv)", "tilt the board by 30 to 45 degrees, both ways, in several images"},
    {2, "principal point (cu, cv)", "turn the board by a quarter and tilt it both ways in several images"},
    {4, "radial distortion (k1, k2)", "bring the board into all corners of the image"},
    {6, "tangential distortion (p1, p2)", "bring the board into all corners of the image"},
}};

/// How far one standard deviation of the pair moves the image's corner, px.
double CornerSigmaPx(const IntrinsicMatrix& covariance, const optics::CameraModel& camera, int first) {
  const Eigen::Matrix2d effect = AtImageCorner(camera).middleCols<2>(first);
  const Eigen::Matrix2d moved = effect * covariance.block<2, 2>(first, first) * effect.transpose();
  return std::sqrt(SpectrumOf(moved).values[1]);
}

}  // namespace

IntrinsicMatrix InverseInformation(const IntrinsicsBundle& bundle) {
  return Inverse(bundle.Information(), bundle.camera);
}

double ImageDispersion(const IntrinsicsBundle& bundle, double sigma0_px) {
  const IntrinsicMatrix information = bundle.Information();
  double sum = 0;
  for (const ImageShare& share : bundle.shares)
    sum += share.gradient.dot(Inverse(information - share.information, bundle.camera) * share.gradient);
  const double variance = sum / (kIntrinsics * sigma0_px * sigma0_px);
  const double chance = kChanceSigma * kVarianceSigma / std::sqrt(static_cast<double>(bundle.shares.size()));
  return variance > 1 + chance ? std::sqrt(variance) : 1;
}

std::string Undetermined(const IntrinsicMatrix& covariance, const optics::CameraModel& camera) {
  const double half_px = std::hypot(camera.width_px, camera.height_px) / 2;
  for (const IntrinsicPair& pair : kPairs) {
    const double moved_px = CornerSigmaPx(covariance, camera, pair.first);
    if (moved_px <= kUndeterminedPct / 100 * half_px) continue;
    return std::string("the images do not determine the ") + pair.name +
           ": its standard deviation is worth " +
           (moved_px < half_px ? Tenths(moved_px) + " px" : "more than half the image") +
           " at the image's corner, " + Tenths(kUndeterminedPct / 100 * half_px) + " px are allowed; " +
           pair.remedy;
  }
  return "";
}

std::vector<std::string> Uncertain(const IntrinsicMatrix& covariance, const optics::CameraModel& camera) {
  std::vector<std::string> sentences;
  for (const IntrinsicPair& pair : kPairs) {
    const double moved_px = CornerSigmaPx(covariance, camera, pair.first);
    if (moved_px > kUncertainPx) {
      sentences.push_back(std::string("one standard deviation of the ") + pair.name + " is worth " +
                          Tenths(moved_px) + " px at the image's corner");
    }
  }
  return sentences;
}

}  // namespace adit::host
