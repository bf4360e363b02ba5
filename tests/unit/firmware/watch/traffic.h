// Truth for the tests of the watch: a loader with two bars before cameras of which the right one may turn.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <optional>
#include <vector>

#include "firmware/stereo/locator.h"
#include "tests/support/synthetic_bar.h"

namespace adit::watch_tests {

/// What a scene does, and how well it is seen.
struct TrafficOptions {
  double noise_px = 0.02;    ///< of every coordinate, stated by the blobs
  double phase_bias_px = 0;  ///< rms of what depends on where on the pixel an LED falls, not stated
  double rate_hz = 60;
  double near_m = 20, far_m = 100;
  double leg_s = 30;  ///< from the near to the far end
  int bars = 2;
  bool with_lights = false;  ///< four fixed LEDs on the walls
};

/// Locates the two bars of a loader that drives to and fro. Ideal pixels, own projection; the locator knows
/// the rig as it was calibrated.
class Traffic {
 public:
  Traffic(const TrafficOptions& options, unsigned seed)
      : options_(options),
        calibrated_(support::ToedInRig()),
        real_(calibrated_),
        scene_(calibrated_, seed),
        locator_(calibrated_.AsRig(), Targets()) {}

  static std::vector<base::Target> Targets() { return {support::SeedTargetOne(), support::SeedTargetTwo()}; }
  double RateHz() const { return options_.rate_hz; }
  optics::Rig Rig() const { return calibrated_.AsRig(); }
  /// From now on, against the calibration: a rotation vector in the right camera's frame.
  void TurnRight(const Eigen::Vector3d& turn_rad) {
    real_.right.rotation = Eigen::AngleAxisd(turn_rad.norm(), turn_rad.normalized()).toRotationMatrix() *
                           calibrated_.right.rotation;
  }
  /// From now on the right camera stands this far from where it was calibrated.
  void ShiftRight(const Eigen::Vector3d& shift_m) {
    real_.right.centre_m = calibrated_.right.centre_m + shift_m;
  }
  /// From now on the whole rig is turned and has shifted against the tunnel by this.
  void Sway(const Eigen::Vector3d& turn_rad, const Eigen::Vector3d& shift_m) {
    sway_turn_ = Eigen::AngleAxisd(turn_rad.norm(), turn_rad.normalized()).toRotationMatrix();
    sway_shift_m_ = shift_m;
  }
  /// What happens to one of the lights from now on.
  struct Harm {
    std::size_t light = 0;
    Eigen::Vector3d moved_m = Eigen::Vector3d::Zero();  ///< someone knocked it
    double brightness = 1, left_px = 0;                 ///< a plate before a part of it, seen from the left
  };
  void Do(const Harm& harm) { harm_ = harm; }
  /// Where the lights are believed to be: 2 cm off.
  std::vector<Eigen::Vector3d> BelievedLights() const {
    auto lights = Lights();
    for (Eigen::Vector3d& light : lights) light += Eigen::Vector3d(0.02, -0.01, 0.02);
    return lights;
  }
  /// From now on the bars are this much longer than the locator believes, each.
  void Stretch(double one, double two) { stretch_ = {one, two}; }
  /// The loader stands from now on.
  void Park() { parked_ = true; }

  /// The next pair, 1 / rate_hz later.
  const stereo::PointSet& Next() {
    if (!parked_) time_s_ += 1 / options_.rate_hz;
    scene_.Clear();
    left_.sightings.clear();
    for (int bar = 0; bar < options_.bars; ++bar) Show(bar);
    if (options_.with_lights) ShowLights();
    left_.blob_set = &scene_.Blobs().left, right_.blob_set = &scene_.Blobs().right;
    locator_.Locate(left_, right_, points_);
    return points_;
  }

 private:
  void Show(int number) {
    const auto index = static_cast<std::size_t>(number);
    const double leg = time_s_ / options_.leg_s, phase = std::abs(std::remainder(leg, 2));
    const double distance_m = options_.near_m + (options_.far_m - options_.near_m) * phase;
    const double weave_m = 0.3 * std::sin(0.9 * time_s_);
    const Eigen::Vector3d at =
        number == 0 ? Eigen::Vector3d(-1.0 + weave_m, 0.2, 0) : Eigen::Vector3d(1.0 + weave_m, 0.1, 0);
    const Eigen::Vector3d direction =
        number == 0 ? Eigen::Vector3d(0.94, -0.33, 0.08) : Eigen::Vector3d(0.92, 0.37, -0.1);
    const auto bar =
        support::SyntheticBar::At(Targets()[index], support::Ahead(calibrated_, distance_m) + at, direction);
    const Eigen::Vector3d middle = bar.Point(0.5 * bar.target.leds_m[3]);
    identify::Sighting sighting;
    sighting.target = static_cast<std::uint8_t>(number);
    for (std::size_t i = 0; i < base::kLedCount; ++i) {
      const Eigen::Vector3d led = middle + (1 + stretch_[index]) * (bar.Point(bar.target.leds_m[i]) - middle);
      sighting.blobs[i] = static_cast<std::uint16_t>(scene_.Blobs().left.blobs.size());
      Shine(led);
    }
    left_.sightings.push_back(sighting);
  }
  std::vector<Eigen::Vector3d> Lights() const {
    std::vector<Eigen::Vector3d> lights;
    const std::vector<Eigen::Vector3d> offsets{{-2.5, -2, 0}, {4, -2.6, 0}, {-5, 3, 0}, {7, -4, 0}};
    const std::vector<double> distances_m{35, 48, 70, 95};
    for (std::size_t i = 0; i < offsets.size(); ++i)
      lights.push_back(support::Ahead(calibrated_, distances_m[i]) + offsets[i]);
    return lights;
  }
  void ShowLights() {
    const auto lights = Lights();
    for (std::size_t i = 0; i < lights.size(); ++i) {
      const bool harmed = harm_ && harm_->light == i;
      Shine(lights[i] + (harmed ? harm_->moved_m : Eigen::Vector3d(Eigen::Vector3d::Zero())));
      if (!harmed) continue;
      detect::Blob& left = scene_.Blobs().left.blobs[scene_.Blobs().left.blobs.size() - 1];
      left.ideal_px.x() += harm_->left_px;
      left.flux_dn *= static_cast<float>(harm_->brightness);
    }
  }
  /// A light at a point of the tunnel, in both images.
  void Shine(const Eigen::Vector3d& point_m) {
    const Eigen::Vector3d seen_m = sway_turn_ * point_m + sway_shift_m_;
    Add(real_.left.ProjectIdeal(seen_m).value(), scene_.Blobs().left);
    Add(real_.right.ProjectIdeal(seen_m).value(), scene_.Blobs().right);
  }
  void Add(const Eigen::Vector2d& px, detect::BlobSet& set) {
    detect::Blob blob;
    const auto noisy = [this](double at) {
      return at + options_.noise_px * scene_.Gauss() +
             options_.phase_bias_px * std::sqrt(2) * std::sin(2 * M_PI * at);
    };
    blob.ideal_px = blob.raw_px = {noisy(px.x()), noisy(px.y())};
    blob.covariance_px2 = options_.noise_px * options_.noise_px * Eigen::Matrix2d::Identity();
    blob.flux_dn = 5000;
    set.blobs.push_back(blob);
  }

  TrafficOptions options_;
  support::SyntheticRig calibrated_, real_;
  support::SyntheticScene scene_;
  stereo::Locator locator_;
  identify::SightingSet left_, right_;
  stereo::PointSet points_;
  std::array<double, 2> stretch_{};
  Eigen::Matrix3d sway_turn_ = Eigen::Matrix3d::Identity();
  Eigen::Vector3d sway_shift_m_ = Eigen::Vector3d::Zero();
  std::optional<Harm> harm_;
  double time_s_ = 0;
  bool parked_ = false;
};

}  // namespace adit::watch_tests
