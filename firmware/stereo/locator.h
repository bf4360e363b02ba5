// SightingSet x2 -> PointSet: epipolar correspondence, triangulation, refinement, validation, rigid bar fit.
#pragma once

#include <memory>
#include <vector>

#include "firmware/base/target.h"
#include "firmware/identify/sighting_set.h"
#include "firmware/optics/rig.h"
#include "firmware/stereo/expectation.h"
#include "firmware/stereo/locator_options.h"
#include "firmware/stereo/point_set.h"

namespace adit::stereo {

/// Locates targets in the rig frame (seed 4.3.5). No allocation after construction; one thread.
///
/// Every left sighting is a hypothesis. Its LEDs' counterparts are sought along the epipolar lines; every
/// choice of them whose distances fit is triangulated, validated and fitted as a rigid bar. So is what has
/// two LEDs or more where a target is expected, and, for a target that is not followed, every three lights in
/// space that stand as three of its LEDs do, unless so many blobs are about that chance makes such. What
/// passes more than once without a clear best is not reported: a wrong position can hurt, a missing one only
/// stops work.
class Locator {
 public:
  Locator(const optics::Rig& rig, const std::vector<base::Target>& targets,
          const LocatorOptions& options = {});
  ~Locator();
  Locator(Locator&&) noexcept;
  Locator& operator=(Locator&&) noexcept;

  /// Fills one entry per target, in model order, found or lost with its reason. `right` needs no sightings,
  /// only its blobs. A frame that is not kOk loses every target (kNoFrame). Both sets must outlive `out`.
  void Locate(const identify::SightingSet& left, const identify::SightingSet& right,
              const ExpectationSet& expectations, PointSet& out);
  /// The same with no target expected anywhere.
  void Locate(const identify::SightingSet& left, const identify::SightingSet& right, PointSet& out);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace adit::stereo
