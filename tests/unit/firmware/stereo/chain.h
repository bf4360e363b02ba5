// What the tests of the located targets share: identification and location on one synthetic rig.
#pragma once

#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "firmware/identify/identifier.h"
#include "firmware/stereo/locator.h"
#include "tests/support/nees.h"
#include "tests/support/synthetic_bar.h"

namespace adit::stereo_tests {

/// Identifier and locator on one synthetic rig.
struct Chain {
  support::SyntheticRig rig;
  std::vector<base::Target> targets;
  std::unique_ptr<identify::Identifier> identifier;
  std::unique_ptr<stereo::Locator> locator;
  identify::SightingSet left, right;
  stereo::PointSet points;
  stereo::ExpectationSet expectations{};  ///< none, unless the test says so

  explicit Chain(std::vector<base::Target> list, const support::SyntheticRig& world = support::ToedInRig())
      : rig(world), targets(std::move(list)) {
    std::vector<identify::Model> models;
    for (const auto& target : targets) models.push_back(support::ModelOf(target));
    identify::IdentifierOptions options;
    options.focal_px = rig.left.f_px;
    identifier = std::make_unique<identify::Identifier>(models, options);
    locator = std::make_unique<stereo::Locator>(rig.AsRig(), targets);
  }
  const stereo::TargetPoints& Run(const support::BlobPair& blobs, std::size_t target = 0) {
    identifier->Identify(blobs.left, left);
    right.blob_set = &blobs.right;
    locator->Locate(left, right, expectations, points);
    return points.targets[target];
  }
};

/// Mahalanobis distance of the reported epicenter from the truth.
inline double ErrorSigmas(const stereo::TargetPoints& p, const support::SyntheticBar& bar) {
  const Eigen::Vector3d error = p.epicenter_b_m - bar.Epicenter();
  return std::sqrt(support::Nees(error, p.epicenter_covariance_m2));
}

}  // namespace adit::stereo_tests
