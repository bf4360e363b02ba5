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
  double centroid_floor_px = 0.01;
  double sigmas = 4;
  /// Of the rigid fit, in standard deviations of a normal variable: a true target exceeds it once in 200 000
  /// (chi-square 45 with 11 degrees of freedom).
  double chi_square_sigmas = 4.4;
  /// The same of two LEDs, and of three without a lock: a true one exceeds it once in 160, which loses a
  /// pair.
  double candidate_sigmas = 2.5;
  /// Two places of one target: the worse is dismissed if its chi-square is this much more (likelihood
  /// e^-12), else both are.
  double chi_square_margin = 25;
  /// What a centroid that should be there and is not counts in that comparison: as much as the margin and a
  /// chi-square that is still usual, so that a place with all four LEDs stands against one with three.
  double hidden_cost = 35;
  /// Places of three LEDs are believed without a lock only if, with the blobs as they stand, chance makes
  /// fewer than this of them in a pair.
  double chance_max = 1e-5;
  /// The same for two LEDs in the place where the target is expected: the lock is the better evidence.
  double expected_chance_max = 3e-6;
};

}  // namespace adit::stereo
