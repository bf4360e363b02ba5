// The image of a shining sphere: a disc under the point spread function, integrated over the pixels.
#pragma once

#include <vector>

#include "drivers/sim/canvas.h"

namespace adit::sim {

/// A round light on the sensor. The image of a sphere off the axis is an ellipse longer by 1/cos of the angle
/// (2 % at 11 degrees) whose centre is displaced by (radius / distance)^2 of its offset (below 0.001 px for
/// an LED): both neglected.
struct Disc {
  double x_px = 0, y_px = 0;
  double radius_px = 0;
  double flux_dn = 0;  ///< sum over all pixels
};

/// Discs under a Gaussian of `sigma_px`. The profile along the radius is the exact convolution, tabulated
/// over the squared distance for radii in steps of 1/32 px up to 6 sigma; what is left of the radius goes
/// into the brightness, so that the flux is exact. Larger discs have the rim of a straight edge. Pixels are
/// integrated by 2 x 2 Gauss-Legendre points (exact to the third order). The profile is symmetric, so the
/// centroid of a disc within the image is its centre.
class SpotPainter {
 public:
  explicit SpotPainter(double sigma_px);

  /// Adds the disc to `canvas` where it overlaps, and marks the tiles.
  void Add(const Disc& disc, Canvas& canvas) const;
  /// Brightness of the disc at `distance_px` from its centre, per pixel of area.
  double Value(const Disc& disc, double distance_px) const;
  /// Where the disc's profile falls below `level_dn`: distance from its centre, 0 if it never reaches it. By
  /// bisection.
  double ExtentPx(const Disc& disc, double level_dn) const;
  /// How far from its centre a disc is painted.
  double ReachPx(double radius_px) const;

 private:
  /// Values at equal steps of the squared distance, for a flux of 1.
  using Profile = std::vector<float>;

  void Tabulate();
  const Profile* Find(double radius_px) const;
  void AddSmall(const Disc& disc, const Profile& profile, const PixelBox& part, Canvas& canvas) const;
  void AddLarge(const Disc& disc, const PixelBox& part, Canvas& canvas) const;
  double LargeSurface(const Disc& disc) const;
  double Edge(double outside_px) const;

  double sigma_px_;
  double per_step_;                ///< steps of a profile per square pixel
  std::vector<Profile> profiles_;  ///< of radius 0, 1/32 px, ...
  std::vector<float> edge_;        ///< of a straight edge, over the distance outside it
};

/// A wide Gaussian (glare, an aureole): point-sampled, cut where it is too faint to matter.
void AddHalo(const Disc& disc, double sigma_px, Canvas& canvas);

}  // namespace adit::sim
