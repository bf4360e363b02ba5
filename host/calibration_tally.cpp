#include "host/calibration_tally.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "host/confidence.h"

namespace adit::host {
namespace {

/// rms error over bound that a calibration may have.
constexpr double kRatioMax = 1.2;

}  // namespace

RigVector ErrorOf(const TrueRig& truth, const optics::Rig& rig) {
  const Eigen::AngleAxisd turn(rig.T_r_l.rotation * truth.rotation.transpose());
  RigVector error;
  error << turn.angle() * turn.axis(), rig.T_r_l.translation_m - truth.translation_m,
      Intrinsics(rig.left) - truth.left, Intrinsics(rig.right) - truth.right;
  return error;
}

Eigen::MatrixXd FreeDirections(const CalibrationInput& input) {
  std::vector<Eigen::RowVectorXd> rows;
  for (Eigen::Index i = 0; i < 6; ++i) rows.emplace_back(RigVector::Unit(i).transpose());
  Eigen::Index first = 6;
  for (const IntrinsicPrior* prior : {&input.left_prior, &input.right_prior}) {
    for (Eigen::Index i = 0; i < kIntrinsics; ++i) {
      const IntrinsicVector column = prior->root.col(i);
      if (column.isZero(0)) continue;
      RigVector row = RigVector::Zero();
      row.segment<kIntrinsics>(first) = column / column.squaredNorm();
      rows.emplace_back(row.transpose());
    }
    first += kIntrinsics;
  }
  Eigen::MatrixXd out(static_cast<Eigen::Index>(rows.size()), optics::kRigParameters);
  for (std::size_t i = 0; i < rows.size(); ++i) out.row(static_cast<Eigen::Index>(i)) = rows[i];
  return out;
}

void Honesty::Add(const Eigen::VectorXd& error, const Eigen::MatrixXd& stated) {
  // Radians, metres and steps: solved with a diagonal of ones.
  const Eigen::VectorXd scale = stated.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::VectorXd n = scale.asDiagonal() * error;
  const Eigen::MatrixXd correlation = scale.asDiagonal() * stated * scale.asDiagonal();
  squares_ += n.dot(correlation.ldlt().solve(n));
  freedom_ += static_cast<double>(n.size());
}

void Honesty::Report(const std::string& what, SuiteReport& report) const {
  const NormalisedErrorLimits bounds(freedom_);
  report.AtLeast(what + ": normalised error^2", squares_ / freedom_, bounds.low);
  report.AtMost(what + ": normalised error^2", squares_ / freedom_, bounds.high);
}

void ErrorTally::Add(const RigVector& error, const optics::RigCovariance& stated,
                     const optics::RigCovariance& bound, const Eigen::MatrixXd& free) {
  const Eigen::VectorXd e = free * error;
  if (squares_.size() == 0) squares_ = Eigen::VectorXd::Zero(e.size()), bounds_ = squares_;
  honesty_.Add(e, free * stated * free.transpose());
  squares_ += e.cwiseAbs2(), bounds_ += (free * bound * free.transpose()).diagonal();
}

void ErrorTally::Report(const std::string& what, Eigen::Index first, Eigen::Index count,
                        SuiteReport& report) const {
  if (squares_.size() == 0) return;  // all refused, which the report says itself
  const Eigen::VectorXd ratios = squares_.segment(first, count).cwiseQuotient(bounds_.segment(first, count));
  report.AtMost(what + ": rms error / bound", std::sqrt(ratios.mean()), kRatioMax);
  report.Inform(what + ": the worst parameter's", std::sqrt(ratios.maxCoeff()));
}

}  // namespace adit::host
