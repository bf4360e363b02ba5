#include "host/training_review.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <sstream>

namespace adit::host {
namespace {

using identify::Model;

// The rms distance of four points from their line has 2 degrees of freedom: its median is 0.589 of a
// coordinate's noise, and one in 150 000 exceeds 2.43 of it.
constexpr double kMedianOfNoise = 0.589, kLimitOfNoise = 2.43;
constexpr double kLossMax = 0.01;          // of all hits: what a narrower range may cost
constexpr double kWiden = 0.02;            // beyond a missed value, as a share of it or of the range
constexpr double kMissFactorMax = 3;       // a value this much beyond its limit is not the target's
constexpr double kNeighbourLengths = 1.5;  // a target moves less than this from image to image
constexpr std::size_t kNeighbourImages = 20;

constexpr std::array<MendedValue, 5> kMendedValues{MendedValue::kP2Min, MendedValue::kP2Max,
                                                   MendedValue::kCollinearityMax, MendedValue::kLengthMin,
                                                   MendedValue::kLengthMax};

const char* NameOf(MendedValue which) {
  constexpr std::array<const char*, 6> kNames{
      "p2_range min", "p2_range max", "collinearity_max", "length_range_px min", "length_range_px max", ""};
  return kNames[static_cast<std::size_t>(which)];
}

bool IsLower(MendedValue which) { return which == MendedValue::kP2Min || which == MendedValue::kLengthMin; }

double FigureOf(MendedValue which, const TrainingSample& figures) {
  if (which == MendedValue::kCollinearityMax) return figures.collinearity;
  return which == MendedValue::kP2Min || which == MendedValue::kP2Max ? figures.p2 : figures.length_px;
}

double& ValueOf(MendedValue which, Model& model) {
  switch (which) {
    case MendedValue::kP2Min:
      return model.p2_min;
    case MendedValue::kP2Max:
      return model.p2_max;
    case MendedValue::kCollinearityMax:
      return model.collinearity_max;
    case MendedValue::kLengthMin:
      return model.length_min_px;
    default:
      return model.length_max_px;
  }
}

std::string ShortNumber(double value, int digits = 4) {
  std::ostringstream text;
  text.precision(digits);
  text << value;
  return text.str();
}

Eigen::Vector2d MiddleOf(const TrainingHit& hit) { return 0.5 * (hit.leds_px.front() + hit.leds_px.back()); }

class ImageReviewer {
 public:
  ImageReviewer(const Model& model, const std::vector<TrainingImage>& images, double noise_px)
      : model_(model), images_(images) {
    for (const TrainingImage& image : images_) {
      passing_.emplace_back();
      for (const TrainingHit& hit : image.hits) {
        if (Passes(model_, hit)) passing_.back().push_back(&hit);
      }
      if (passing_.back().size() == 1) good_.push_back(passing_.back()[0]->figures);
    }
    review_.noise_px = MeasuredNoisePx();
    review_.collinearity_limit_px = kLimitOfNoise * std::max(noise_px, review_.noise_px);
  }

  TrainingReview Review() {
    for (std::size_t i = 0; i < images_.size(); ++i) {
      const auto& hits = passing_[i];
      ++(hits.empty() ? review_.none : hits.size() == 1 ? review_.one : review_.several);
      if (hits.size() > 1) ReviewSecond(i);
      if (hits.size() == 1) ReviewLine(i);
      if (hits.empty()) ReviewMissed(i);
    }
    return std::move(review_);
  }

 private:
  double MeasuredNoisePx() const {
    if (good_.empty()) return 0;
    std::vector<double> rms_px;
    for (const TrainingSample& sample : good_) rms_px.push_back(sample.collinearity * sample.length_px);
    const auto middle = rms_px.begin() + static_cast<std::ptrdiff_t>(rms_px.size() / 2);
    std::nth_element(rms_px.begin(), middle, rms_px.end());
    return *middle / kMedianOfNoise;
  }

  /// How far from the middle of the trained ranges: the target's own hit is the nearest.
  double Oddness(const TrainingHit& hit) const {
    const double half = 0.5 * (model_.p2_max - model_.p2_min);
    const double p2 = (hit.figures.p2 - 0.5 * (model_.p2_min + model_.p2_max)) / half;
    const double line = hit.figures.collinearity * hit.figures.length_px / review_.collinearity_limit_px;
    return std::hypot(p2, line);
  }

  void ReviewSecond(std::size_t image) {
    const auto own =
        std::min_element(passing_[image].begin(), passing_[image].end(),
                         [&](const auto* a, const auto* b) { return Oddness(*a) < Oddness(*b); });
    for (const TrainingHit* hit : passing_[image]) {
      if (hit == *own) continue;
      ImageProblem problem{image, ProblemKind::kSecondMatch, *hit, Cut(*hit, &(*own)->figures), {}, {}};
      problem.finding = "second match: p2 " + ShortNumber(hit->figures.p2) + ", collinearity " +
                        ShortNumber(hit->figures.collinearity, 2) + ", " +
                        ShortNumber(hit->figures.length_px, 3) + " px long";
      problem.proposal = problem.mend.which == MendedValue::kNone
                             ? "looks like the target (a reflection?): leave the image out"
                             : Proposal(problem.mend, "discards it");
      review_.problems.push_back(problem);
    }
  }

  void ReviewLine(std::size_t image) {
    const TrainingHit& hit = *passing_[image][0];
    const double rms_px = hit.figures.collinearity * hit.figures.length_px;
    if (rms_px <= review_.collinearity_limit_px) return;
    ImageProblem problem{image, ProblemKind::kNonCollinear, hit, Cut(hit, nullptr, true), {}, {}};
    problem.finding = "match of non-collinear blobs: " + ShortNumber(rms_px, 2) +
                      " px rms off their line; noise explains " +
                      ShortNumber(review_.collinearity_limit_px, 2) + " px";
    problem.proposal = problem.mend.which == MendedValue::kNone ? "leave the image out"
                                                                : Proposal(problem.mend, "discards it");
    review_.problems.push_back(problem);
  }

  /// The value that cuts `hit` off at the least cost; kNone if each costs too much. `own`: what must stay.
  Mend Cut(const TrainingHit& hit, const TrainingSample* own, bool line_only = false) const {
    Mend best;
    best.hits_lost = std::numeric_limits<std::size_t>::max();
    double best_gap = 0;
    for (const MendedValue which : kMendedValues) {
      if (line_only && which != MendedValue::kCollinearityMax) continue;
      const double figure = FigureOf(which, hit.figures);
      // Halfway to the nearest good hit that stays; where hits lie beyond, just short of the figure.
      double nearest = IsLower(which) ? std::numeric_limits<double>::infinity() : 0;
      std::size_t beyond = 0;
      for (const TrainingSample& sample : good_) {
        const double value = FigureOf(which, sample);
        if (IsLower(which) ? value <= figure : value >= figure)
          ++beyond;
        else
          nearest = IsLower(which) ? std::min(nearest, value) : std::max(nearest, value);
      }
      const bool keeps_own = own == nullptr || (IsLower(which) ? FigureOf(which, *own) > figure
                                                               : FigureOf(which, *own) < figure);
      if (!keeps_own || !std::isfinite(nearest) || nearest <= 0) continue;
      if (own != nullptr)
        nearest = IsLower(which) ? std::min(nearest, FigureOf(which, *own))
                                 : std::max(nearest, FigureOf(which, *own));
      const double gap = std::abs(nearest / figure - 1) / (which <= MendedValue::kP2Max ? 0.1 : 1);
      // A non-collinear hit counts itself among the good ones.
      const std::size_t lost = beyond - (own == nullptr ? 1 : 0);
      if (lost < best.hits_lost || (lost == best.hits_lost && gap > best_gap)) {
        best = {which, 0.5 * (nearest + figure), lost, 0};
        best_gap = gap;
      }
    }
    const auto allowed = static_cast<std::size_t>(kLossMax * static_cast<double>(good_.size()));
    return best.which != MendedValue::kNone && best.hits_lost <= allowed ? best : Mend{};
  }

  std::string Proposal(const Mend& mend, const std::string& effect) const {
    std::string text = std::string(NameOf(mend.which)) + " " + ShortNumber(mend.value) + " " + effect +
                       " and loses " + std::to_string(mend.hits_lost) + " of " +
                       std::to_string(good_.size()) + " hits";
    if (mend.matches_more > 0)
      text +=
          "; " + std::to_string(mend.matches_more) + " images gain a second match, so that it is not applied";
    return text;
  }

  /// How far beyond the trained ranges: 0 within; values missed by.
  double Miss(const TrainingHit& hit, MendedValue& missed, int& values) const {
    double worst = 0;
    values = 0;
    Model model = model_;
    for (const MendedValue which : kMendedValues) {
      const double figure = FigureOf(which, hit.figures), limit = ValueOf(which, model);
      if (IsLower(which) ? figure >= limit : figure <= limit) continue;
      const double scale = which <= MendedValue::kP2Max ? model_.p2_max - model_.p2_min : limit;
      const double miss = std::abs(figure - limit) / scale;
      ++values;
      if (miss >= worst) worst = miss, missed = which;
    }
    return worst;
  }

  /// The target's place in the image of this camera nearest in time that shows it once, if one is near.
  const TrainingHit* Neighbour(std::size_t image) const {
    for (std::size_t step = 1; step <= kNeighbourImages; ++step) {
      for (const std::size_t at : {image - step, image + step}) {
        if (at >= images_.size() || passing_[at].size() != 1)
          continue;  // image - step may wrap: then it is large
        if (images_[at].recording == images_[image].recording && images_[at].side == images_[image].side)
          return passing_[at][0];
      }
    }
    return nullptr;
  }

  void ReviewMissed(std::size_t image) {
    const TrainingHit* neighbour = Neighbour(image);
    const TrainingHit* nearest = nullptr;
    MendedValue missed = MendedValue::kNone, which = MendedValue::kNone;
    double least = kMissFactorMax;
    int values = 0, values_missed = 0;
    for (const TrainingHit& hit : images_[image].hits) {
      const double miss = Miss(hit, which, values);
      const bool in_place = neighbour == nullptr || (MiddleOf(hit) - MiddleOf(*neighbour)).norm() <
                                                        kNeighbourLengths * neighbour->figures.length_px;
      if (!in_place || miss >= least) continue;
      least = miss, nearest = &hit, missed = which, values_missed = values;
    }
    if (nearest == nullptr) {
      ++review_.absent;
      return;
    }
    ImageProblem problem{image, ProblemKind::kMissed, *nearest, {}, {}, {}};
    if (!nearest->within_noise) {
      problem.finding =
          "no match: four blobs in the target's place fit it only beyond the noise of their centroids";
      problem.proposal =
          "an LED merged, smeared or half hidden; no trained value mends it: leave the image out";
    } else {
      DescribeMiss(missed, values_missed, least, problem);
    }
    review_.problems.push_back(problem);
  }

  void DescribeMiss(MendedValue missed, int values, double miss, ImageProblem& problem) const {
    problem.finding = std::string("no match: the nearest quadruple misses ") + NameOf(missed) + " by " +
                      ShortNumber(100 * miss, 2) + " %" +
                      (missed <= MendedValue::kP2Max ? " of the range" : "");
    if (values > 1) {
      problem.finding += ", and " + std::to_string(values - 1) + " other";
      problem.proposal = "misses more than one value: leave the image out";
      return;
    }
    const double figure = FigureOf(missed, problem.hit.figures);
    const double margin = kWiden * (missed <= MendedValue::kP2Max ? model_.p2_max - model_.p2_min : figure);
    problem.mend = {missed, figure + (IsLower(missed) ? -margin : margin), 0, 0};
    const Model wider = Mended(model_, problem.mend);
    for (std::size_t i = 0; i < images_.size(); ++i) {
      const auto& hits = images_[i].hits;
      const auto now =
          std::count_if(hits.begin(), hits.end(), [&](const auto& h) { return Passes(wider, h); });
      problem.mend.matches_more += passing_[i].size() <= 1 && now > 1 ? 1 : 0;
    }
    problem.proposal = Proposal(problem.mend, "accepts it");
  }

  const Model& model_;
  const std::vector<TrainingImage>& images_;
  std::vector<std::vector<const TrainingHit*>> passing_;
  std::vector<TrainingSample> good_;
  TrainingReview review_;
};

}  // namespace

TrainingReview ReviewImages(const Model& model, const std::vector<TrainingImage>& images, double noise_px) {
  return ImageReviewer(model, images, noise_px).Review();
}

Model Mended(Model model, const Mend& mend) {
  if (mend.which != MendedValue::kNone) ValueOf(mend.which, model) = mend.value;
  return model;
}

}  // namespace adit::host
