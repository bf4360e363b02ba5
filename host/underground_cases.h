// The cases of the suite `underground`.
#pragma once

#include "host/episode.h"
#include "host/suite_cases.h"

namespace adit::host {

/// Every tenth piece of a large count is rendered.
inline Imaging ImagingOf(std::size_t index) {
  return index % 10 == 0 ? Imaging::kRendered : Imaging::kCentroids;
}

/// Three targets among 20 to 200 lamps, a tenth of them collinear with LEDs, LEDs hidden now and then.
/// Counted in target-frames (full count: 1 000 000).
SuiteReport MeasureSwaps(const CaseOrder& order);
/// Lamps, rows of lamps, headlights and their reflections: nothing may be reported. Counted in pairs
/// (100 000).
SuiteReport MeasureLamps(const CaseOrder& order);
/// Each target over water that mirrors it. Counted in target-frames (30 000).
SuiteReport MeasureMirror(const CaseOrder& order);
/// Fog of 0.02 per metre at 50 m, rendered. Counted in target-frames (3 000).
SuiteReport MeasureFog(const CaseOrder& order);
/// The drive of the seed from 20 to 110 m, rendered. Counted in frames (2 560).
SuiteReport MeasureDrive(const CaseOrder& order);
/// Table 5.6 of the seed, rendered. Counted in frames a distance and test (200).
SuiteReport MeasureVibration(const CaseOrder& order);
/// Whether the stated 95 % ellipsoids hold. Counted in positions a distance (20 000).
SuiteReport MeasureEllipsoid(const CaseOrder& order);
/// Spread of a target at rest against the bound. Counted in frames a distance (20 000).
SuiteReport MeasureStatic(const CaseOrder& order);
/// Fifteen bars of 1 m at 110 m. Counted in target-frames (150 000).
SuiteReport MeasureFifteen(const CaseOrder& order);

}  // namespace adit::host
