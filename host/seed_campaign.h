// One of the seed's rigs calibrated again and again, and what it measures then.
#pragma once

#include <string>
#include <vector>

#include "firmware/base/result.h"
#include "host/seed_bound.h"

namespace adit::host {

/// What was measured at a place: root mean squares over the calibrations.
struct PlaceFigures {
  double bar_bias_m = 0;                              ///< of the mean error of the bar length
  double bar_sigma_m = 0;                             ///< of its spread
  double half_bar_m = 0;                              ///< of the seed's xRMS(P)
  double position_m = 0;                              ///< of the epicenter's mean error
  Eigen::Vector3d sigma_m = Eigen::Vector3d::Zero();  ///< of the measured epicenter's spread, middle frame
  std::size_t frames = 0, lost = 0;                   ///< of all calibrations together
};

struct PlaceComparison {
  PlaceFigures measured;
  PlaceBound bound;
};

/// The frames of one place.
struct PlaceOrder {
  base::Target target;
  std::vector<BarPose> poses;
};

class SeedCampaign {
 public:
  /// Waves and calibrates `calibrations` times; everything follows from the seed. Declines as Calibrate does.
  static base::Result<SeedCampaign> Run(const SeedSetup& setup, std::size_t calibrations, std::uint64_t seed);

  const optics::Rig& Truth() const { return truth_; }
  std::size_t Calibrations() const { return rigs_.size(); }
  /// Identifies and locates the target in every frame by every calibrated rig, without a filter, and states
  /// the bound of the same frames. A frame in which an LED is out of view is a bug of the caller's.
  PlaceComparison Measure(const PlaceOrder& place) const;

 private:
  SeedCampaign(const SeedSetup& setup, std::uint64_t seed) : setup_(setup), seed_(seed) {}

  SeedSetup setup_;
  std::uint64_t seed_;
  optics::Rig truth_;
  std::vector<optics::Rig> rigs_;
  optics::RigCovariance calibration_bound_ = optics::RigCovariance::Zero();
};

}  // namespace adit::host
