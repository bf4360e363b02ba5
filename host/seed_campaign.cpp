#include "host/seed_campaign.h"

#include <cmath>
#include <memory>

#include "firmware/base/require.h"
#include "firmware/identify/identifier.h"
#include "firmware/stereo/locator.h"
#include "host/calibration.h"
#include "host/training.h"
#include "host/tunnel.h"

namespace adit::host {
namespace {

using Eigen::Vector3d;

constexpr std::uint64_t kWaveStream = 0x77617665, kTrackStream = 0x747261636b;
constexpr base::TimeNs kWavePeriodNs = 100'000'000;

/// The box's stages after the detection, for one target.
class BarTracker {
 public:
  BarTracker(const optics::Rig& rig, const base::Target& target)
      : rig_(rig), identifiers_{Make(rig.left, target), Make(rig.right, target)}, locator_(rig, {target}) {}

  const stereo::TargetPoints& Track(const BarPixels& pixels, double noise_px) {
    FillBlobs(rig_, pixels, noise_px, *blobs_);
    for (std::size_t side = 0; side < 2; ++side)
      identifiers_[side].Identify((*blobs_)[side], sightings_[side]);
    locator_.Locate(sightings_[0], sightings_[1], points_);
    return points_.targets[0];
  }

 private:
  static identify::Identifier Make(const optics::CameraModel& camera, const base::Target& target) {
    TrainingOptions training;
    training.farthest_m = 130;
    identify::IdentifierOptions options;
    options.focal_px = camera.fu_px;
    return identify::Identifier({GeometryModel(target, training)}, options);
  }

  optics::Rig rig_;
  std::array<identify::Identifier, 2> identifiers_;
  stereo::Locator locator_;
  std::unique_ptr<std::array<detect::BlobSet, 2>> blobs_ = std::make_unique<std::array<detect::BlobSet, 2>>();
  std::array<identify::SightingSet, 2> sightings_;
  stereo::PointSet points_;
};

/// Sums over the frames of one place and one rig.
class FrameSums {
 public:
  void Add(const stereo::TargetPoints& points, const base::Target& target, const Vector3d& truth_b_m) {
    ++count_;
    const double miss_m = points.bar_m - target.LengthM();
    bar_m_ += miss_m, bar_m2_ += miss_m * miss_m, length_m2_ += points.bar_m * points.bar_m;
    places_m_.push_back(points.epicenter_b_m);
    place_m_ += points.epicenter_b_m;
    error_m_ += points.epicenter_b_m - truth_b_m;
  }
  bool IsEmpty() const { return count_ == 0; }

  /// Adds this rig's figures, squared.
  void AddSquares(const base::Target& target, const Eigen::Matrix3d& R_m_b, PlaceFigures& sums) const {
    const auto n = static_cast<double>(count_);
    const double bias_m = bar_m_ / n;
    sums.bar_bias_m += bias_m * bias_m;
    sums.bar_sigma_m += (bar_m2_ / n - bias_m * bias_m) * n / (n - 1);
    sums.half_bar_m += std::pow(0.5 * (target.LengthM() - std::sqrt(length_m2_ / n)), 2);
    sums.position_m += (error_m_ / n).squaredNorm();
    for (const Vector3d& place_m : places_m_)
      sums.sigma_m += (R_m_b * (place_m - place_m_ / n)).cwiseAbs2() / (n - 1);
  }

 private:
  std::size_t count_ = 0;
  double bar_m_ = 0, bar_m2_ = 0, length_m2_ = 0;
  Vector3d error_m_ = Vector3d::Zero(), place_m_ = Vector3d::Zero();
  std::vector<Vector3d> places_m_;
};

}  // namespace

base::Result<SeedCampaign> SeedCampaign::Run(const SeedSetup& setup, std::size_t calibrations,
                                             std::uint64_t seed) {
  SeedCampaign campaign(setup, seed);
  campaign.truth_ = TunnelRig(setup.base_m, setup.converge_m);
  const optics::Rig& truth = campaign.truth_;
  for (std::size_t k = 0; k < calibrations; ++k) {
    SeedDraw draw(seed, kWaveStream + k);
    const double length_scale = 1 + setup.bar_sigma_m * draw.Normal() / setup.bar.LengthM();
    CalibrationInput input{{"calibration " + std::to_string(k)}, {}, {}, {setup.bar}, {}};
    input.left_prior = PriorOf(setup.lens, truth.left), input.right_prior = PriorOf(setup.lens, truth.right);
    input.bar_sigma_m = setup.bar_sigma_m;
    optics::Rig believed = truth;  // its pose is not looked at
    believed.left = input.left = draw.Mistaken(truth.left, input.left_prior);
    believed.right = input.right = draw.Mistaken(truth.right, input.right_prior);
    std::vector<BarPose> poses;
    for (std::size_t frame = 0; frame < setup.frames; ++frame) {
      poses.push_back(draw.Wave(truth, setup, length_scale));
      const BarPixels pixels = *PixelsOf(truth, setup.bar, poses.back(), length_scale);
      input.bars.push_back(StereoBarOf(believed, draw.Noisy(pixels, setup.noise_px), setup.noise_px));
      input.bars.back().mid_exposure_ns = static_cast<base::TimeNs>(frame) * kWavePeriodNs;
    }
    CalibrationOptions options;
    options.hold_out_every = 0;  // the bound counts every bar
    const auto calibration = Calibrate(input, options);
    if (!calibration) return calibration.error();
    campaign.rigs_.push_back(calibration->rig);
    campaign.calibration_bound_ += WandBound(truth, setup, poses) / static_cast<double>(calibrations);
  }
  return campaign;
}

PlaceComparison SeedCampaign::Measure(const PlaceOrder& place) const {
  const Eigen::Matrix3d R_m_b = MiddleFrame(truth_).R_b_m.transpose();
  PlaceComparison out;
  std::size_t rigs = 0;
  for (std::size_t k = 0; k < rigs_.size(); ++k) {
    SeedDraw draw(seed_, kTrackStream + k);
    BarTracker tracker(rigs_[k], place.target);
    FrameSums sums;
    for (const BarPose& pose : place.poses) {
      const auto pixels = PixelsOf(truth_, place.target, pose);
      ADIT_REQUIRE(pixels.has_value());
      const auto& points = tracker.Track(draw.Noisy(*pixels, setup_.noise_px), setup_.noise_px);
      ++out.measured.frames;
      if (points.status == stereo::FixStatus::kTracked)
        sums.Add(points, place.target, pose.Point(place.target.epicenter_m));
      else
        ++out.measured.lost;
    }
    if (sums.IsEmpty()) continue;
    ++rigs;
    sums.AddSquares(place.target, R_m_b, out.measured);
  }
  // With nothing found the figures are NaN and hold no bar.
  const auto mean = [rigs](double sum) { return std::sqrt(sum / static_cast<double>(rigs)); };
  PlaceFigures& m = out.measured;
  m.bar_bias_m = mean(m.bar_bias_m), m.bar_sigma_m = mean(m.bar_sigma_m), m.half_bar_m = mean(m.half_bar_m);
  m.position_m = mean(m.position_m);
  m.sigma_m = m.sigma_m.unaryExpr(mean);
  out.bound = BoundAt(truth_, calibration_bound_, place.target, place.poses, setup_.noise_px);
  return out;
}

}  // namespace adit::host
