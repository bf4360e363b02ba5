#include "host/train_session.h"

#include <algorithm>
#include <set>

#include "host/confusion.h"

namespace adit::host {
namespace {

constexpr int kApplyRounds = 3;

std::string ImageName(const Training& training, const TrainingImage& image) {
  return training.recordings[image.recording] + " " + std::to_string(image.mid_exposure_ns) +
         (image.side == base::Side::kLeft ? " cam0" : " cam1");
}

/// Leaves out the images of the given times.
base::Result<void> Discard(const std::vector<base::TimeNs>& times, Training& training) {
  for (const base::TimeNs time_ns : times) {
    const auto removed = std::erase_if(
        training.images, [time_ns](const TrainingImage& image) { return image.mid_exposure_ns == time_ns; });
    if (removed == 0) {
      return base::Error{base::ErrorCode::kUsage, "--discard " + std::to_string(time_ns),
                         "is the time of no image; times are as in data.csv, in ns"};
    }
    training.applied.push_back(std::to_string(time_ns) + " left out as asked: " + std::to_string(removed) +
                               " images");
  }
  return {};
}

std::string Counts(const TrainingTally& tally) {
  return std::to_string(tally.none + tally.one + tally.several) + " images: " + std::to_string(tally.one) +
         " with one hit, " + std::to_string(tally.none) + " with none, " + std::to_string(tally.several) +
         " with several";
}

bool ApplyValues(const TrainingReview& review, bool widening, Training& training) {
  bool changed = false;
  for (const ImageProblem& problem : review.problems) {
    const Mend& mend = problem.mend;
    const bool is_widening = problem.kind == ProblemKind::kMissed;
    if (mend.which == MendedValue::kNone || is_widening != widening || mend.matches_more > 0) continue;
    // An earlier mend may have done this one's work.
    if (Passes(training.model, problem.hit) == is_widening) continue;
    training.model = Mended(training.model, mend);
    training.applied.push_back(ImageName(training, training.images[problem.image]) + ": " + problem.proposal);
    changed = true;
  }
  return changed;
}

bool LeaveUnmendedOut(const TrainingReview& review, Training& training) {
  std::set<std::size_t> unmended;
  for (const ImageProblem& problem : review.problems) {
    if (problem.mend.which == MendedValue::kNone || problem.mend.matches_more > 0)
      unmended.insert(problem.image);
  }
  for (auto i = unmended.rbegin(); i != unmended.rend(); ++i) {
    training.applied.push_back(ImageName(training, training.images[*i]) +
                               ": left out, no trained value mends it");
    training.images.erase(training.images.begin() + static_cast<std::ptrdiff_t>(*i));
  }
  return !unmended.empty();
}

}  // namespace

void ApplyMends(const TrainOrder& order, Training& training) {
  training.doubt = GeometryDoubt(training);  // the images that raise it may be left out
  for (int round = 0; round < kApplyRounds; ++round) {
    bool changed = ApplyValues(training.review, true, training);
    changed = ApplyValues(training.review, false, training) || changed;
    changed = LeaveUnmendedOut(training.review, training) || changed;
    if (!changed) return;
    training.review = ReviewImages(training.model, training.images, order.options.noise_px);
  }
}

base::Result<Training> Train(const TrainOrder& order) {
  Training training;
  training.options = order.options;
  training.recordings = order.recordings;
  training.size_px = order.size_px;
  training.model = GeometryModel(order.target, order.options);
  for (const identify::Model& other : order.others) {
    const ViewConditions view{order.options.tilt_max_rad, order.options.focal_px, order.options.noise_px};
    training.others.push_back({other, DistinctUpToM(order.target, other.target, order.options.nearest_m,
                                                    order.options.farthest_m, view)});
  }
  if (order.recordings.empty()) {
    if (order.discarded.empty() && !order.apply) return training;
    return base::Error{base::ErrorCode::kUsage, order.apply ? "--apply" : "--discard",
                       "goes with --recording only"};
  }
  for (std::size_t i = 0; i < order.recordings.size(); ++i) {
    const TrainingRecording recording{order.recordings[i], order.camera};
    if (auto searched = SearchRecording(recording, i, training.model, training.images); !searched)
      return searched.error();
  }
  if (auto discarded = Discard(order.discarded, training); !discarded) return discarded.error();
  const TrainingTally tally = TallyOf(training.model, training.images);
  if (tally.one == 0) {
    return base::Error{base::ErrorCode::kFailed, order.recordings.front(),
                       "shows '" + order.target.name + "' in no image exactly once (" + Counts(tally) +
                           "); check leds_m in " + order.target_file};
  }
  training.model = RefinedModel(NoiseRanges(order.target, order.options), tally);
  training.review = ReviewImages(training.model, training.images, order.options.noise_px);
  if (order.apply) ApplyMends(order, training);
  return training;
}

}  // namespace adit::host
