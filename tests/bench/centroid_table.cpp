// Centroids of rendered LEDs beside the Cramer-Rao bound: isolated, clipped, smeared, near each other and
// merged, with 8 bits and 12. Usage: centroid_table [images of 56 cells a line, default 100]
#include <cstdio>
#include <cstdlib>

#include "tests/support/centroid_trials.h"

int main(int argc, char** argv) {
  const int images = argc > 1 ? std::atoi(argv[1]) : 100;
  if (images < 1) {
    std::fprintf(stderr, "centroid_table: %s: a number of images, at least 1\n", argv[1]);
    return 2;
  }
  unsigned seed = 0;
  const auto measure = [&](const adit::support::TrialKind& kind) {
    adit::support::Measure(kind, images, ++seed);
  };
  for (const int bits : {8, 12}) {
    for (const double sigma_px : {1.2, 1.5, 2.0, 2.5})
      for (const double peak_dn : {30.0, 50.0, 100.0, 200.0, 300.0, 400.0, 800.0})
        measure({.peak_dn = peak_dn, .sigma_px = sigma_px, .bits = bits});
    for (const double smear_px : {2.0, 4.0, 6.0, 8.0})
      for (const double peak_dn : {100.0, 240.0, 600.0})
        measure({.peak_dn = peak_dn, .smear_px = smear_px, .bits = bits});
    for (const double sigma_px : {1.2, 1.5, 2.0})
      for (const double gap_px : {3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 12.0})
        measure({.peak_dn = 200, .sigma_px = sigma_px, .gap_px = gap_px, .bits = bits});
    for (const double gap_px : {3.0, 5.0, 8.0})
      for (const double peak_dn : {60.0, 400.0})
        measure({.peak_dn = peak_dn, .gap_px = gap_px, .bits = bits});
    for (const double gap_px : {3.0, 5.0, 8.0})
      measure({.peak_dn = 200, .gap_px = gap_px, .second_peak = 0.5, .bits = bits});
  }
  return 0;
}
