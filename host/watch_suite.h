// The suite `watch`: whether the box notices that its calibration no longer holds, and how seldom it errs.
// Simulation.
#pragma once

#include "host/suite_cases.h"

namespace adit::host {

/// A yaw of 10 urad at a random time, at several centroid noises: when it is found, the estimated correction
/// against the truth in its stated sigmas, and what the Cramer-Rao bound says of the same traffic. Counted in
/// seeds a noise.
SuiteReport MeasureStep(const CaseOrder& order);
/// No turn, but a rig that shifts as warming steel does: false alarms. Counted in hours of traffic.
SuiteReport MeasureQuiet(const CaseOrder& order);
/// A yaw that grows by 20 urad an hour. Counted in seeds.
SuiteReport MeasureDrift(const CaseOrder& order);

/// Runs the cases (`--case`): step, quiet, drift.
int RunWatch(const SuiteOrder& order);

}  // namespace adit::host
