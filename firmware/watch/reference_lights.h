// LEDs that are fixed to the tunnel -> information about the right camera's motion.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "firmware/stereo/view.h"
#include "firmware/watch/information.h"

namespace adit::watch {

/// Single LEDs at known places of the rig frame. What is compared is where their images were while the
/// reference was learned and where they are now, so that the places need to be known to a few pixels only and
/// the phase bias of their centroids cancels.
///
/// The rig as a whole may turn freely against the tunnel and shift by `kSwayM`: these six are projected out.
/// Three lights at least must be seen, or one that was knocked could not be told from a camera that was. A
/// light is left out of a pair while another blob is near it, or while its brightness is not the learned one
/// (something stands before half of it). No allocation after construction; one thread.
class ReferenceLights {
 public:
  static constexpr double kSwayM = 1e-3;  ///< of a mast or a pillar, 1 sigma an axis
  /// What the air between bends the view of a light by for longer than half a minute, 1 sigma a coordinate.
  /// Assumed: the half of the least that it moves a single image by at 100 m (0.007 px).
  static constexpr double kAirPx = 0.004;

  ReferenceLights(const stereo::Views& views, const std::vector<Eigen::Vector3d>& places_b_m);

  /// One pair. Looks at images that were searched all over; returns how many lights it found in both.
  int Add(const detect::BlobSet& left, const detect::BlobSet& right);

  /// Ends a second. If three lights with a reference were seen in it: information on the change since. What
  /// does not average out over time (the air, the reference's own noise, the sway) is stated so large that
  /// `seconds` of these together hold it once. `wrong` counts seconds in which the lights contradict each
  /// other; they tell nothing.
  std::optional<Information> EndSecond(int seconds, std::uint32_t& wrong);

  /// What was seen since the start, or since Forget, becomes the reference of the lights that have none and
  /// were seen in `pairs_min` pairs.
  void Learn(int pairs_min);
  void Forget();
  /// At least one light has a reference.
  bool Learned() const;

 private:
  /// Sums over pairs; left and right.
  struct Sight {
    stereo::ObservationPair sums{};
    std::array<double, 2> flux_dn{};
    int pairs = 0;

    void Add(const std::array<const detect::Blob*, 2>& blobs);
    /// Of the mean.
    stereo::Observation Mean(std::size_t side) const;
  };
  struct Light {
    Eigen::Vector3d place_b_m = Eigen::Vector3d::Zero();
    std::array<Eigen::Vector2d, 2> px{Eigen::Vector2d::Zero(), Eigen::Vector2d::Zero()};  ///< where to look
    bool in_view = false;  ///< before both cameras
    Sight second, learning, reference;
  };
  struct Sums;

  bool Look(Light& light, const std::array<const detect::BlobSet*, 2>& images);
  Sums Gather(int seconds) const;

  stereo::Views views_;
  std::vector<Light> lights_;
};

}  // namespace adit::watch
