// What a detection would make of a simulated world, without rendering it.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "drivers/sim/random.h"
#include "drivers/sim/world.h"
#include "firmware/detect/blob_set.h"

namespace adit::host {

/// One standard deviation (px) of a centroid's coordinate at the Cramer-Rao bound: read noise 1.5 DN,
/// 40 electrons a DN, 8 bit; by the height of the spot above the background, interpolated between computed
/// values. It does not depend on the spot's width from 0.8 to 2.5 px.
double CentroidNoisePx(double peak_dn);

/// Simulated centroids. The projection, the lens and its inversion are the simulator's own; nothing here is
/// of the stages that are tested.
///
/// A light gives a blob where the camera receives it: at its disc's middle, or at the middle of the part that
/// is not hidden (as bright pixels would tell). Discs whose bright parts touch run together into one blob at
/// their common centre of brightness, long or large ones are no LEDs any more, as in an image. Gaussian noise
/// at the bound is drawn on the raw pixel, and the blob's covariance states it; what a neighbour or an edge
/// moves, no covariance states. Not simulated: motion blur, glare, false spots of noise.
class SimulatedBlobs {
 public:
  /// `world` must outlive this. `noise_scale` multiplies the noise and what is stated of it.
  explicit SimulatedBlobs(const sim::World& world, double noise_scale = 1)
      : world_(world), noise_scale_(noise_scale) {}

  /// Replaces the noise of every centroid by this one (px); 0: by brightness again.
  void FixNoise(double noise_px) { fixed_noise_px_ = noise_px; }
  /// Whether neighbours run together.
  void RunTogether(bool together) { together_ = together; }

  /// The blobs of one side at a trigger, in scan order. Depends on the scene's seed, side and trigger alone.
  void Expose(base::Side side, std::uint64_t trigger, detect::BlobSet& blobs);

 private:
  /// One or more discs whose bright parts touch, as moments of the brightness.
  struct Spot {
    double x_px = 0, y_px = 0, flux_dn = 0;
    double xx = 0, yy = 0, xy = 0;  ///< second moments about the middle, px^2
    double extent_px = 0;           ///< of the largest disc
    double peak_dn = 0, area_px = 0;
    Eigen::Vector2d low_px = Eigen::Vector2d::Constant(HUGE_VAL);  ///< corners of the box
    Eigen::Vector2d high_px = Eigen::Vector2d::Constant(-HUGE_VAL);
  };

  void Gather(base::Side side, double t_s);
  void Join();
  void Append(const Spot& spot, base::Side side, sim::Random& random, detect::BlobSet& blobs) const;

  const sim::World& world_;
  double noise_scale_;
  double fixed_noise_px_ = 0;
  bool together_ = true;
  std::vector<Spot> spots_;
  std::vector<std::size_t> group_;
};

/// Raw pixel -> ideal pixel by the plain fixed point on the simulator's projection, and its derivative by
/// differences.
Eigen::Vector2d IdealPx(const optics::CameraModel& camera, const Eigen::Vector2d& raw_px,
                        Eigen::Matrix2d& slope);

}  // namespace adit::host
