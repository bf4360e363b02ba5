// Three lights in space that may be three LEDs of a bar.
#pragma once

#include <array>
#include <bitset>
#include <vector>

#include "firmware/base/target.h"
#include "firmware/stereo/locator_options.h"
#include "firmware/stereo/point_cloud.h"
#include "firmware/stereo/point_set.h"

namespace adit::stereo {

/// Three points for three LEDs of a target; the fourth LED has kNoBlob in both images.
struct Triple {
  std::uint8_t target = 0;
  BarBlobs blobs{};
};

/// What a search found.
struct TripleSet {
  static constexpr std::size_t kMaxTriples = 128;
  base::FixedVector<Triple, kMaxTriples> triples;
  /// By target: how many triples chance makes of blobs as dense as these, expected in one pair.
  std::array<double, identify::kMaxTargets> chance{};
  bool cut_short = false;  ///< it reached its budget, or found more than fit: nothing may be concluded
};

/// Searches a cloud of points for triples. Three collinear points have no invariant in one image; with their
/// places in space they have: the two outer points must be as far apart as two LEDs are, and the inner one
/// must stand between them, in both images, where the perspective that the depths tell puts the LED.
/// One thread; no allocation.
class TripleSearch {
 public:
  TripleSearch(const optics::Rig& rig, const std::vector<base::Target>& targets,
               const LocatorOptions& options);

  /// Triples of the targets in `wanted`.
  void Run(const PointCloud& cloud, const std::bitset<identify::kMaxTargets>& wanted, TripleSet& out) const;

 private:
  struct Outer;
  /// Where the inner LED must stand in one image.
  struct Gate {
    Eigen::Vector2d px, along;  ///< its place, and the unit direction of the bar there
    double noise_px = 0, tight_px = 0;
  };
  using Gates = std::array<Gate, 2>;

  void TryPair(const PointCloud& cloud, const Outer& pair, const std::bitset<identify::kMaxTargets>& wanted,
               TripleSet& out) const;
  Gates GatesOf(const Outer& pair, std::size_t inner) const;
  double ChanceOf(const PointCloud& cloud, const Gates& gates) const;
  void SeekInner(const PointCloud& cloud, const Outer& pair, std::size_t inner, TripleSet& out) const;

  std::vector<base::Target> targets_;
  LocatorOptions options_;
  double focal_px_, width_px_;
  double longest_m_ = 0;
};

}  // namespace adit::stereo
