// Errors of many simulated calibrations, against their bound and against what they state.
#pragma once

#include <Eigen/Core>
#include <string>

#include "host/simulated_calibration.h"
#include "host/suite_report.h"

namespace adit::host {

/// `rig` less truth; the turn as a rotation vector in the right camera's frame.
RigVector ErrorOf(const TrueRig& truth, const optics::Rig& rig);

/// The pose, and the intrinsics' steps that the priors leave free: one row each.
Eigen::MatrixXd FreeDirections(const CalibrationInput& input);

/// Normalised squares: their mean must lie within the 95 % chi-square bounds.
class Honesty {
 public:
  /// `error` has the covariance `stated`, if that is honest.
  void Add(const Eigen::VectorXd& error, const Eigen::MatrixXd& stated);
  void Report(const std::string& what, SuiteReport& report) const;

 private:
  double squares_ = 0, freedom_ = 0;
};

class ErrorTally {
 public:
  void Add(const RigVector& error, const optics::RigCovariance& stated, const optics::RigCovariance& bound,
           const Eigen::MatrixXd& free);

  /// rms error over bound, rms over the parameters from `first` on, and the worst of them.
  void Report(const std::string& what, Eigen::Index first, Eigen::Index count, SuiteReport& report) const;
  void ReportHonesty(const std::string& what, SuiteReport& report) const { honesty_.Report(what, report); }

 private:
  Eigen::VectorXd squares_, bounds_;
  Honesty honesty_;
};

}  // namespace adit::host
