// Mean and scatter of vectors, over runs that each have a mean of their own.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstddef>

namespace adit::host {

/// Mean and sum of squared deviations (Welford 1962), addable within a run.
class Spread {
 public:
  void Add(const Eigen::Vector3d& value) {
    ++count_;
    const Eigen::Vector3d before = value - mean_;
    mean_ += before / static_cast<double>(count_);
    squares_ += before.cwiseProduct(value - mean_);
  }
  std::size_t Count() const { return count_; }
  const Eigen::Vector3d& Mean() const { return mean_; }
  /// Sum of squared deviations from the mean, per axis; it has Count() - 1 degrees of freedom.
  const Eigen::Vector3d& Squares() const { return squares_; }
  Eigen::Vector3d Deviation() const { return (squares_ / (static_cast<double>(count_) - 1)).cwiseSqrt(); }

 private:
  std::size_t count_ = 0;
  Eigen::Vector3d mean_ = Eigen::Vector3d::Zero(), squares_ = Eigen::Vector3d::Zero();
};

}  // namespace adit::host
