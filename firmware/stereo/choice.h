// One answer per target, or none: what to do when several places pass.
#pragma once

#include <vector>

#include "firmware/base/fixed_vector.h"
#include "firmware/stereo/mirrors.h"
#include "firmware/stereo/solution.h"

namespace adit::stereo {

inline constexpr std::size_t kMaxSolutions = 8;  ///< of one target; more are ambiguous anyway

/// What the search found for one target.
struct Finding {
  base::FixedVector<Solution, kMaxSolutions> solutions;
  LossReason reason = LossReason::kNotSeen;  ///< of the hypothesis that came farthest
  bool crowded = false;                      ///< hypotheses were left out: nothing may be concluded
};

/// Adds a solution. Solutions at one place (within `options.sigmas` and 10 mm) count as the better one.
void Add(const LocatorOptions& options, const Solution& solution, Finding& finding);

/// Whether a solution takes these blobs, and perhaps more, for these LEDs.
bool Explains(const Solution& solution, const BarBlobs& blobs);

/// The one solution that stands, or null with `finding.reason` set.
///
/// A place and its mirror image in a plane count as the one on the cameras' side of the plane: the other is
/// its reflection, in water or a wall. That holds too for the place where the target is `expected` or was
/// a moment ago (null: nowhere) but not seen, and for any place behind a mirror that is known. Of what
/// remains, the best stands if its cost is smaller by `options.chi_square_margin`; otherwise none does
/// (kAmbiguous).
const Solution* Choose(const LocatorOptions& options, const Solution* expected, Mirrors& mirrors,
                       Finding& finding);

/// Whether two solutions take one blob.
bool ShareABlob(const Solution& a, const Solution& b);

/// No blob belongs to two targets: of two that share one, the clearly better stands, or neither. A place that
/// was found for another target and not chosen contests too. `chosen` has
/// an entry per target (null: none); those that fall become null with their finding's reason kAmbiguous, or
/// kNotSeen where the blobs are clearly the other's.
void ResolveShared(const LocatorOptions& options, std::vector<const Solution*>& chosen,
                   std::vector<Finding>& findings);

}  // namespace adit::stereo
