#include "host/bundle_covariance.h"

#include <array>
#include <vector>

#include "host/bundle_costs.h"
#include "host/normal_matrix.h"

namespace adit::host {
namespace {

template <int kRows, int kColumns>
using RowMajor = Eigen::Matrix<double, kRows, kColumns, kColumns == 1 ? Eigen::ColMajor : Eigen::RowMajor>;

constexpr int kLengths = optics::kRigParameters;  // where the lengths begin among the reduced parameters

/// The reduced normal matrix over pose, both cameras' steps, and the lengths' steps.
class Reduced {
 public:
  Reduced(const BundleSetting& setting, const BundleState& state)
      : frame_{&setting, state.T_r_l.rotation}, targets_(setting.targets.size()) {
    normal_.setZero(kLengths + static_cast<Eigen::Index>(targets_),
                    kLengths + static_cast<Eigen::Index>(targets_));
    Eigen::Map<Eigen::Vector3d>(pose_.data() + 3) = state.T_r_l.translation_m;
    left_ = setting.left_prior.Steps(Intrinsics(setting.left), Intrinsics(state.left));
    right_ = setting.right_prior.Steps(Intrinsics(setting.right), Intrinsics(state.right));
    for (std::size_t i = 0; i < targets_; ++i) {
      const double sigma = setting.bar_sigma_m / setting.targets[i].LengthM();
      lengths_.push_back(sigma > 0 ? (state.length_scale[i] - 1) / sigma : 0);
    }
  }

  bool Add(const StereoBar& bar, const BarPlace& place) {
    const BarCost cost(frame_, bar, place.direction_l);
    const Eigen::Vector3d& c = place.centre_l_m;
    const std::array<double, kBarSize> at{c.x(), c.y(), c.z(), 0, 0};
    RowMajor<kBarResiduals, kPoseSize> by_pose;
    RowMajor<kBarResiduals, kIntrinsics> by_left, by_right;
    RowMajor<kBarResiduals, 1> by_length;
    RowMajor<kBarResiduals, kBarSize> by_bar;
    std::array<double, kBarResiduals> residuals{};
    const std::array<const double*, 5> parameters{pose_.data(), left_.data(), right_.data(),
                                                  &lengths_[bar.target], at.data()};
    std::array<double*, 5> jacobians{by_pose.data(), by_left.data(), by_right.data(), by_length.data(),
                                     by_bar.data()};
    if (!cost.Evaluate(parameters.data(), residuals.data(), jacobians.data())) return false;
    Eigen::MatrixXd shared(kBarResiduals, kLengths + 1);
    shared << by_pose, by_left, by_right, by_length;
    const Eigen::MatrixXd share = ReducedNormalMatrix(shared, by_bar);
    const auto length = kLengths + static_cast<Eigen::Index>(bar.target);
    normal_.topLeftCorner<kLengths, kLengths>() += share.topLeftCorner<kLengths, kLengths>();
    normal_.block<kLengths, 1>(0, length) += share.topRightCorner<kLengths, 1>();
    normal_.block<1, kLengths>(length, 0) += share.bottomLeftCorner<1, kLengths>();
    normal_(length, length) += share(kLengths, kLengths);
    return true;
  }

  bool Add(const StereoPoint& point, const Eigen::Vector3d& place_l_m) {
    RowMajor<kPointResiduals, kPoseSize> by_pose;
    RowMajor<kPointResiduals, kIntrinsics> by_left, by_right;
    RowMajor<kPointResiduals, kPointSize> by_point;
    std::array<double, kPointResiduals> residuals{};
    const std::array<const double*, 4> parameters{pose_.data(), left_.data(), right_.data(),
                                                  place_l_m.data()};
    std::array<double*, 4> jacobians{by_pose.data(), by_left.data(), by_right.data(), by_point.data()};
    if (!PointCost(frame_, point).Evaluate(parameters.data(), residuals.data(), jacobians.data()))
      return false;
    Eigen::MatrixXd shared(kPointResiduals, kLengths);
    shared << by_pose, by_left, by_right;
    normal_.topLeftCorner<kLengths, kLengths>() += ReducedNormalMatrix(shared, by_point);
    return true;
  }

  /// With the priors, inverted; the lengths marginalised; in units of the parameters.
  std::optional<optics::RigCovariance> Inverse() const {
    Eigen::MatrixXd normal = normal_;
    normal.diagonal().tail(normal.rows() - kPoseSize).array() += 1;
    // Radians, metres and sigmas: judged and inverted with a diagonal of ones.
    const Eigen::VectorXd unit = normal.diagonal().cwiseSqrt().cwiseInverse();
    if (!unit.allFinite()) return std::nullopt;
    const Spectrum eigen = SpectrumOf(unit.asDiagonal() * normal * unit.asDiagonal());
    // Below 1e-13 of the largest is rounding, not knowledge.
    if (!(eigen.values[0] > 1e-13 * eigen.values.maxCoeff())) return std::nullopt;
    const Eigen::MatrixXd inverse = unit.asDiagonal() * eigen.vectors *
                                    eigen.values.cwiseInverse().asDiagonal() * eigen.vectors.transpose() *
                                    unit.asDiagonal();
    optics::RigCovariance units = optics::RigCovariance::Identity();
    units.block<kIntrinsics, kIntrinsics>(kPoseSize, kPoseSize) = frame_.setting->left_prior.root;
    units.bottomRightCorner<kIntrinsics, kIntrinsics>() = frame_.setting->right_prior.root;
    return optics::RigCovariance(units * inverse.topLeftCorner<kLengths, kLengths>() * units.transpose());
  }

 private:
  BundleFrame frame_;
  std::size_t targets_;
  Eigen::MatrixXd normal_;
  std::array<double, kPoseSize> pose_{};
  IntrinsicVector left_, right_;
  std::vector<double> lengths_;
};

}  // namespace

std::optional<optics::RigCovariance> BundleCovariance(const BundleSetting& setting, const BundleData& data,
                                                      const BundleState& state) {
  Reduced reduced(setting, state);
  for (std::size_t i = 0; i < data.bars.size(); ++i) {
    if (!reduced.Add(data.bars[i], state.places[i])) return std::nullopt;
  }
  for (std::size_t i = 0; i < data.points.size(); ++i) {
    if (!reduced.Add(data.points[i], state.points_l_m[i])) return std::nullopt;
  }
  return reduced.Inverse();
}

}  // namespace adit::host
