// What the stereo stage believes and what it allows.
#pragma once

namespace adit::stereo {

/// Tolerances are `sigmas` standard deviations of what the centroids' covariances propagate to, plus what a
/// calibration in use may be off by.
struct LocatorOptions {
  /// Distance of a centroid from its epipolar line: rigs turn after calibration; 1 px is 60 arc seconds at
  /// f = 3400 px, a few hours of sun on a mount.
  double epipolar_px = 1.0;
  /// Of every distance: 1 px of convergence at 100 m, base 9 m, is 0.33 %; a bar known to 0.1 mm and a
  /// baseline to 0.1 % come on top.
  double scale = 0.005;
  /// What no covariance of pixel noise holds (identify::IdentifierOptions has the same).
  double centroid_floor_px = 0.05;
  double sigmas = 4;
  /// Of the rigid fit, 11 degrees of freedom: a true target exceeds it once in 200 000.
  double chi_square_max = 45;
  /// Two places of one target: the worse is dismissed if its chi-square is this much more (likelihood
  /// e^-12), else both are.
  double chi_square_margin = 25;
};

}  // namespace adit::stereo
