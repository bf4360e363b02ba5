// Training images that a model does not read well, and the value that mends each (seed 4.4.2, figures 4.20
// and 4.21).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/training_images.h"

namespace adit::host {

enum class ProblemKind {
  kSecondMatch,   ///< more than one hit: a reflection, a chance alignment of lamps
  kNonCollinear,  ///< one hit, farther from its line than noise explains
  kMissed,        ///< none, although something like the target is there
};

/// The trained value that a mend changes.
enum class MendedValue { kP2Min, kP2Max, kCollinearityMax, kLengthMin, kLengthMax, kNone };

/// What is proposed for one problem: a new value, or (kNone) to leave the image out.
struct Mend {
  MendedValue which = MendedValue::kNone;
  double value = 0;
  std::size_t hits_lost = 0;     ///< images that have one hit and would have none
  std::size_t matches_more = 0;  ///< images that would have more hits than one and have at most one
};

struct ImageProblem {
  std::size_t image = 0;  ///< index into the images
  ProblemKind kind = ProblemKind::kSecondMatch;
  TrainingHit hit;  ///< the match too many, or the one that nearly passes
  Mend mend;
  std::string finding, proposal;  ///< for people: what is wrong, what would mend it
};

struct TrainingReview {
  std::size_t one = 0, none = 0, several = 0;  ///< images by hits
  std::size_t absent =
      0;                ///< of `none`: nothing like the target is there, so that it may well be out of view
  double noise_px = 0;  ///< of a centroid's coordinate, as the images' distances from their lines show
  double collinearity_limit_px = 0;  ///< rms distance from the line that noise explains
  std::vector<ImageProblem> problems;
};

/// Judges every image. What noise explains is the larger of `noise_px` and what the images themselves show.
/// A match too many is cut off by the value that costs the fewest hits, when that is at most one in a
/// hundred; a missed target is let in by the value it misses, when nothing else misses and no other image
/// gains a second match.
TrainingReview ReviewImages(const identify::Model& model, const std::vector<TrainingImage>& images,
                            double noise_px);

/// The model with a mend's value.
identify::Model Mended(identify::Model model, const Mend& mend);

}  // namespace adit::host
