// The suite `underground`: never a wrong machine, and the right one whenever it can be seen. Simulation.
#pragma once

#include "host/suites.h"

namespace adit::host {

/// Runs the cases (`--case`): swaps, lamps, mirror, fog, drive, vibration, ellipsoid, static, fifteen.
///
/// The pipeline of the box (identification, stereo, tracking) locates targets whose truth is known. Nine
/// tenths of the large counts stand on simulated centroids (simulated_blobs.h), one tenth on rendered images
/// that it also detects in; every line says which. The same seed and count give the same figures, however
/// many cores there are.
int RunUnderground(const SuiteOrder& order);

}  // namespace adit::host
