// Truth for tests of the geometry: bars and lamps seen by two cameras, projected by code of its own.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <random>

#include "firmware/base/target.h"
#include "firmware/detect/blob_set.h"
#include "firmware/identify/model.h"
#include "firmware/optics/rig.h"

namespace adit::support {

/// A pinhole with Brown's distortion, written apart from optics::CameraModel.
struct SyntheticCamera {
  double f_px = 3378, cu_px = 699.5, cv_px = 511.5;
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0;
  int width_px = 1400, height_px = 1024;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();  ///< R_c_b
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();      ///< in b

  /// Without distortion; nothing for points behind the camera.
  std::optional<Eigen::Vector2d> ProjectIdeal(const Eigen::Vector3d& point_b_m) const;
  Eigen::Vector2d Distorted(const Eigen::Vector2d& ideal_px) const;
  Eigen::Vector2d Undistorted(const Eigen::Vector2d& raw_px) const;
  bool InImage(const Eigen::Vector2d& raw_px) const;
};

/// Two of them, the left one's frame being the rig frame.
struct SyntheticRig {
  SyntheticCamera left, right;
  optics::Rig AsRig() const;
};

/// 1400 x 1024, f = 3378 px, `base_m` apart, toed in so that the axes cross `converge_m` ahead; slight lens
/// distortion (8 px in the corner).
SyntheticRig ToedInRig(double base_m = 9, double converge_m = 35);

/// In the rig frame, `distance_m` straight ahead of the middle between the cameras of `rig`.
Eigen::Vector3d Ahead(const SyntheticRig& rig, double distance_m);
/// The same for `ToedInRig()`.
inline Eigen::Vector3d AheadM(double distance_m) { return Ahead(ToedInRig(), distance_m); }

/// A bar somewhere in the rig frame.
struct SyntheticBar {
  base::Target target;
  Eigen::Vector3d led1_b_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d direction_b = Eigen::Vector3d::UnitX();

  Eigen::Vector3d Point(double place_m) const { return led1_b_m + place_m * direction_b; }
  Eigen::Vector3d Epicenter() const { return Point(target.epicenter_m); }
  /// The bar with its middle at `middle_m`.
  static SyntheticBar At(const base::Target& target, const Eigen::Vector3d& middle_m,
                         const Eigen::Vector3d& direction);
  /// Its image in a water surface at `water_y_m`; y points down.
  SyntheticBar MirroredAt(double water_y_m) const {
    SyntheticBar image = *this;
    image.led1_b_m.y() = 2 * water_y_m - led1_b_m.y();
    image.direction_b.y() *= -1;
    return image;
  }
};

/// The seed's two targets, 1.5 m long, and a 0.82 m one whose tip lies beyond LED 4.
base::Target SeedTargetOne();
base::Target SeedTargetTwo();
base::Target ShortTarget();

/// A model as training from geometry would give it, f = 3378 px, from `nearest_m` to 120 m.
identify::Model ModelOf(const base::Target& target, double nearest_m = 4);

/// The blobs of one pair.
struct BlobPair {
  detect::BlobSet left, right;
};

/// Makes blobs. `seed` fixes every number drawn.
class SyntheticScene {
 public:
  explicit SyntheticScene(const SyntheticRig& rig, unsigned seed = 1);

  /// Removes all blobs.
  void Clear();
  /// Adds the LEDs of a bar to both images, with Gaussian noise of `sigma_px` a coordinate on the raw pixel,
  /// which the blobs' covariance states. False, and nothing added, if an LED is outside an image.
  bool AddBar(const SyntheticBar& bar, double sigma_px);
  /// Adds `count` lamps at random places in each image, unrelated between the images.
  void AddLamps(int count, double sigma_px);
  /// Adds one blob at a raw place.
  void AddBlob(base::Side side, const Eigen::Vector2d& raw_px, double sigma_px, float flux_dn = 5000);
  /// Puts the blobs of both images in random order.
  void Shuffle();

  BlobPair& Blobs() { return blobs_; }
  double Uniform(double low, double high);
  double Gauss();
  Eigen::Vector3d Direction();

 private:
  SyntheticRig rig_;
  std::mt19937_64 random_;
  BlobPair blobs_;
};

}  // namespace adit::support
