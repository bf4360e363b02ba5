// A target that is followed, sought where it is expected, with as few as two LEDs.
#pragma once

#include "firmware/stereo/bar_builder.h"
#include "firmware/stereo/choice.h"
#include "firmware/stereo/correspondence.h"
#include "firmware/stereo/expectation.h"
#include "firmware/stereo/point_cloud.h"

namespace adit::stereo {

/// The expectation in the shape of a solution: places and covariance of the epicenter, no blobs.
Solution ExpectedPlace(const base::Target& target, const Expectation& expected);

/// Whether a solution is where the target is expected: the ends of the bar, both covariances.
bool IsExpected(const base::Target& target, const Expectation& expected, const Solution& solution);

/// Blobs within the gates of the expected LED images are assigned; every two LEDs that are seen in both
/// images and fit make a bar, and what else fits is added to it. The expectation gates and never weighs: the
/// place is that of the blobs alone, and two points fix a line. One thread; no allocation.
class ExpectedSearch {
 public:
  ExpectedSearch(const optics::Rig& rig, const LocatorOptions& options);

  /// Adds to `finding` what is found. `builder` and `correspondence` have the pair set. Declines where more
  /// blobs stand in a gate than can be told apart.
  void Run(const base::Target& target, const Expectation& expected, const BarBuilder& builder,
           const Correspondence& correspondence, Finding& finding);

  /// Sets the flags of the lights that the last Run took for LEDs of its target, whether or not it found it.
  void Mark(BlobFlags& flags) const;

 private:
  static constexpr std::size_t kMaxInGate = 12;
  struct Pair {
    std::array<std::uint16_t, 2> blobs{};
    LocatedPoint located;
  };
  using Gate = base::FixedVector<std::uint16_t, kMaxInGate>;

  bool Collect(const base::Target& target, const Expectation& expected, const BarBuilder& builder,
               const Correspondence& correspondence);
  bool CollectGate(const LocatedPoint& led, std::size_t side, const detect::BlobSet& blobs, Gate& gate);
  void TryPairs(const base::Target& target, const Expectation& expected, const BarBuilder& builder,
                const std::array<std::size_t, 2>& leds, Finding& finding);
  /// How many pairs of blobs chance puts where one LED is, one expects, given another LED's place.
  double Chance() const;

  Views views_;
  LocatorOptions options_;
  std::array<double, 2> image_px2_;
  std::array<base::FixedVector<Pair, kMaxInGate>, base::kLedCount> pairs_;
  std::array<double, 2> density_per_px2_{};  ///< of blobs, in each image
  double largest_gate_px2_ = 0;              ///< in the left image
  int builds_ = 0;
};

}  // namespace adit::stereo
