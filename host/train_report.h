// What training tells: what the recordings covered, what they showed, what is wrong with them.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/report_page.h"
#include "host/training_review.h"

namespace adit::host {

/// A target that must not be taken for this one.
struct OtherTarget {
  identify::Model model;
  std::optional<double> distinct_up_to_m;  ///< DistinctUpToM over the trained distances
};

/// A training, all of it.
struct Training {
  TrainingOptions options;
  identify::Model model;                ///< what is written
  std::vector<std::string> recordings;  ///< none: from geometry alone
  Eigen::Vector2i size_px{1400, 1024};  ///< of the images
  std::vector<TrainingImage> images;
  TrainingReview review;             ///< of the images, by `model`
  std::vector<std::string> applied;  ///< mends that were applied, and images that were left out
  std::string doubt;                 ///< of the target file, before images were left out; empty: none
  std::vector<OtherTarget> others;
};

/// Distances at which the bar was seen: classes of equal ratio from nearest to farthest. An image tells
/// focal length times bar length over image length: the distance if the bar is held across the view; leaning,
/// it looks farther. For the invariant that is what counts.
struct DistanceClass {
  double from_m = 0, to_m = 0;
  std::size_t hits = 0;
};
std::vector<DistanceClass> DistanceClasses(const Training& training);
/// Stretches of the trained distances with fewer than ten hits a class: "5 to 9.3 m"; empty: all covered, or
/// nothing recorded.
std::vector<std::string> UncoveredDistances(const Training& training);

/// When the target is in place again and again but never fits, it is not built as its file says: a sentence
/// about the images of `training.review`; empty: no doubt.
std::string GeometryDoubt(const Training& training);

/// What a person must know, as sentences; empty if the training is good.
std::vector<std::string> TrainingWarnings(const Training& training);

ReportPage MakeTrainReport(const Training& training);

}  // namespace adit::host
