// Whether four blobs, in order, pass for a target's four LEDs.
#pragma once

#include <array>
#include <optional>

#include "firmware/identify/blob_grid.h"
#include "firmware/identify/model.h"
#include "firmware/identify/p2_invariant.h"
#include "firmware/identify/sighting_set.h"

namespace adit::identify {

/// What may differ from camera to camera. A tolerance is `sigmas` times the propagated standard deviation of
/// the centroids, to which `centroid_floor_px` is added in quadrature.
struct IdentifierOptions {
  /// Focal length, for the bound on the perspective: LED images at given spacings and a given length tell how
  /// far the bar is. 0: not known, `perspective_max` alone holds.
  double focal_px = 0;
  /// Largest |Z4 - Z1| / Z1 of a bar: 1.5 m end-on at 4.3 m.
  double perspective_max = 0.35;
  /// What no covariance of pixel noise holds: the lens' residue over the length of a bar, the last of the
  /// phase bias. More, and an LED that has merged with a lamp passes for one that has not.
  double centroid_floor_px = 0.01;
  double sigmas = 4;  ///< one true target in 4000 fails one of its four tests
};

/// Places on the grid of the four blobs that stand for LED 1 to LED 4.
using Quadruple = std::array<std::size_t, base::kLedCount>;

/// One model made ready for testing.
///
/// A bar that starts at depth Z1 and gains c Z1 of depth per metre images the place s (metres from LED 1) at
/// t(s) = a s / (1 + c s) along its image line. Four places fix a, c and one more number: the cross ratio,
/// which is the target's own. c tells the direction of the bar: read backwards, an unsymmetric layout would
/// need a depth gain that no bar at a trained distance has.
class QuadrupleTest {
 public:
  QuadrupleTest(const Model& model, const IdentifierOptions& options);

  /// The sighting, if order, length, collinearity, p2 and perspective fit; `target` is left 0.
  std::optional<Sighting> Judge(const BlobGrid& grid, const Quadruple& leds) const;

  /// Largest |Z4 - Z1| / Z1 at which the bar's image can be `length_px` long.
  double PerspectiveMax(double length_px) const;

  const Model& GetModel() const { return model_; }
  const IdentifierOptions& Options() const { return options_; }

 private:
  bool Collinear(const LinePlaces& along_px, const LinePlaces& across_px, const LinePlaces& sigma_px) const;
  bool HasCrossRatio(const LinePlaces& along_px, const LinePlaces& sigma_px) const;
  bool HasPerspective(const LinePlaces& along_px, const LinePlaces& sigma_px) const;
  double RmsFromLine(const LinePlaces& along_px, const LinePlaces& across_px) const;

  Model model_;
  IdentifierOptions options_;
  double cross_ratio_;  ///< of the target as built
  std::size_t middle_;  ///< inner LED nearest the middle: the best lever for the perspective
};

}  // namespace adit::identify
