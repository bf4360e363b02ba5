// The suite `calibration`: how near the bound calibrations come, and whether their covariance is honest.
// Simulation.
#pragma once

#include "host/suite_cases.h"

namespace adit::host {

/// The relative pose with exact intrinsics: 1100 frames of a 0.82 m bar at 15 to 30 m, base 9 m, centroids of
/// 0.01 and 0.05 px; rms error against the bound, normalised errors against chi-square.
SuiteReport MeasurePose(const CaseOrder& order);
/// The same with camera files that are wrong by 0.05 % of the focal length, 1 px of the principal point and
/// 0.2 px of distortion (1 sigma), and a bar wrong by 0.1 mm; refined against extrinsics alone at 100 m.
SuiteReport MeasureRefined(const CaseOrder& order);
/// Table 5.2 of the seed: bar length errors at 30, 50 and 70 m, base 6 and 12 m.
SuiteReport MeasureTable52(const CaseOrder& order);
/// Table 5.4 of the seed: positions from 20 to 100 m, base 9 m, 1.5 m bars waved near and far.
SuiteReport MeasureTable54(const CaseOrder& order);

/// A bar waved among 14 lamps, 3 machines' headlights, an LED hidden in a fifth of the frames: the pose less
/// that of the same waving without them, by both covariances. Every tenth recording is rendered.
SuiteReport MeasureClutter(const CaseOrder& order);
/// Rendered recordings through the detection, judged as `intrinsics` is.
SuiteReport MeasureRendered(const CaseOrder& order);

/// Runs the cases (`--case`): pose, intrinsics, table52, table54, clutter, rendered; `--count` is that of the
/// calibrations. The first four stand on simulated centroids.
int RunCalibrationSuite(const SuiteOrder& order);

}  // namespace adit::host
