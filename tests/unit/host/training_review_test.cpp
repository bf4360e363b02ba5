#include "host/training_review.h"

#include <string>

#include "host/train_report.h"
#include "host/train_session.h"

#include <CppUTest/TestHarness.h>

namespace {

using adit::base::Side;
using adit::host::ImageProblem;
using adit::host::MendedValue;
using adit::host::ProblemKind;
using adit::host::ReviewImages;
using adit::host::TallyOf;
using adit::host::Training;
using adit::host::TrainingHit;
using adit::host::TrainingImage;
using adit::host::TrainingReview;
using adit::identify::Model;

constexpr double kNoisePx = 0.05;

Model Trained() {
  Model model;
  model.target = {"bar", {0, 0.25, 0.65, 1.5}, 0, 0.04};
  model.p2_min = 2.22, model.p2_max = 2.33;
  model.collinearity_max = 0.005;
  model.length_min_px = 20, model.length_max_px = 1100;
  return model;
}

TrainingHit Hit(double p2, double line_px = 0.02, double length_px = 200, double u_px = 300) {
  TrainingHit hit;
  hit.figures = {p2, line_px / length_px, length_px};
  for (std::size_t i = 0; i < 4; ++i)
    hit.leds_px[i] = {u_px + length_px * Trained().target.leds_m[i] / 1.5, 400};
  return hit;
}

/// 60 images of cam0 with one good hit each, p2 from 2.26 to 2.28.
std::vector<TrainingImage> GoodImages() {
  std::vector<TrainingImage> images;
  for (int i = 0; i < 60; ++i)
    images.push_back({0, Side::kLeft, 1000 + i, 5, {Hit(2.26 + 0.0003 * i, 0.02 + 0.001 * (i % 10))}});
  return images;
}

/// The review of these images, of which only `at` is odd.
ImageProblem OneProblem(const std::vector<TrainingImage>& images, std::size_t at) {
  const TrainingReview review = ReviewImages(Trained(), images, kNoisePx);
  LONGS_EQUAL(1, review.problems.size());
  LONGS_EQUAL(at, review.problems[0].image);
  return review.problems[0];
}

}  // namespace

TEST_GROUP(TrainingReview) { std::vector<TrainingImage> images_ = GoodImages(); };

TEST(TrainingReview, FindsNothingWrongWithGoodImages) {
  const TrainingReview review = ReviewImages(Trained(), images_, kNoisePx);
  LONGS_EQUAL(60, review.one);
  CHECK(review.problems.empty());
}

// The seed's figure 4.21 b the other way round: the range is so wide that something else passes.
TEST(TrainingReview, CutsASecondMatchOffByTheP2RangeWhenThatLosesNothing) {
  images_[7].hits.push_back(Hit(2.32, 0.02, 200, 900));
  const ImageProblem problem = OneProblem(images_, 7);
  CHECK(problem.kind == ProblemKind::kSecondMatch);
  CHECK(problem.mend.which == MendedValue::kP2Max);
  CHECK_COMPARE(problem.mend.value, >, 2.28);
  CHECK_COMPARE(problem.mend.value, <, 2.32);
  LONGS_EQUAL(0, problem.mend.hits_lost);
  STRCMP_CONTAINS("p2_range max", problem.proposal.c_str());
  STRCMP_CONTAINS("loses 0 of 59 hits", problem.proposal.c_str());
  LONGS_EQUAL(0, ReviewImages(Mended(Trained(), problem.mend), images_, kNoisePx).problems.size());
}

// The seed's figure 4.20: a puddle mirrors the target. No range can tell.
TEST(TrainingReview, LeavesAnImageWithAReflectionOut) {
  images_[7].hits.push_back(Hit(2.2705, 0.021, 195, 320));
  const ImageProblem problem = OneProblem(images_, 7);
  CHECK(problem.mend.which == MendedValue::kNone);
  STRCMP_CONTAINS("reflection", problem.proposal.c_str());
}

// The seed's figure 4.21 a.
TEST(TrainingReview, NarrowsTheCollinearityThatLetsNonCollinearBlobsPass) {
  images_[9].hits = {Hit(2.27, 0.8)};
  const ImageProblem problem = OneProblem(images_, 9);
  CHECK(problem.kind == ProblemKind::kNonCollinear);
  CHECK(problem.mend.which == MendedValue::kCollinearityMax);
  CHECK_COMPARE(problem.mend.value, >, 0.03 / 200);
  CHECK_COMPARE(problem.mend.value, <, 0.8 / 200);
  LONGS_EQUAL(0, problem.mend.hits_lost);
}

TEST(TrainingReview, NeverNarrowsAtTheCostOfManyHits) {
  // Half of the good hits are as far off their lines, relative to their length, as the wrong one.
  for (std::size_t i = 0; i < 30; ++i) images_[2 * i].hits = {Hit(2.27, 0.1, 25)};
  images_[9].hits = {Hit(2.27, 0.8)};
  const ImageProblem problem = OneProblem(images_, 9);
  CHECK(problem.mend.which == MendedValue::kNone);
  STRCMP_EQUAL("leave the image out", problem.proposal.c_str());
}

// The seed's figure 4.21 b: the range is too narrow.
TEST(TrainingReview, LetsAMissedTargetInByTheValueItMisses) {
  images_[12].hits = {Hit(2.345)};
  const ImageProblem problem = OneProblem(images_, 12);
  CHECK(problem.kind == ProblemKind::kMissed);
  CHECK(problem.mend.which == MendedValue::kP2Max);
  CHECK_COMPARE(problem.mend.value, >, 2.345);
  CHECK_COMPARE(problem.mend.value, <, 2.35);
  STRCMP_CONTAINS("misses p2_range max by 14 % of the range", problem.finding.c_str());
  LONGS_EQUAL(60, TallyOf(Mended(Trained(), problem.mend), images_).one);
}

TEST(TrainingReview, SaysWhenLettingOneInWouldLetAnotherIn) {
  images_[12].hits = {Hit(2.345)};
  images_[40].hits.push_back(Hit(2.34, 0.02, 200, 900));
  const ImageProblem problem = OneProblem(images_, 12);
  LONGS_EQUAL(1, problem.mend.matches_more);
  STRCMP_CONTAINS("1 images gain a second match", problem.proposal.c_str());
}

TEST(TrainingReview, MendsNothingBeyondTheNoiseOfTheCentroids) {
  images_[12].hits = {Hit(2.40)};
  images_[12].hits[0].within_noise = false;
  const ImageProblem problem = OneProblem(images_, 12);
  CHECK(problem.mend.which == MendedValue::kNone);
  STRCMP_CONTAINS("no trained value mends it", problem.proposal.c_str());
}

TEST(TrainingReview, TakesLampsElsewhereForNoTarget) {
  images_[12].hits = {Hit(2.345, 0.02, 200, 1100)};
  const TrainingReview review = ReviewImages(Trained(), images_, kNoisePx);
  CHECK(review.problems.empty());
  LONGS_EQUAL(1, review.absent);
  LONGS_EQUAL(1, review.none);
}

TEST(TrainingReview, AppliesWhatItProposesAndLeavesTheRestOut) {
  images_[7].hits.push_back(Hit(2.2705, 0.021, 195, 320));  // a reflection
  images_[12].hits = {Hit(2.345)};                          // missed
  images_[20].hits.push_back(Hit(2.225, 0.02, 200, 900));   // a second match
  Training training;
  training.recordings = {"rec"};
  training.model = Trained(), training.images = images_;
  training.review = ReviewImages(training.model, training.images, kNoisePx);
  LONGS_EQUAL(3, training.review.problems.size());

  ApplyMends({}, training);

  CHECK(training.review.problems.empty());
  LONGS_EQUAL(59, training.review.one);
  LONGS_EQUAL(59, training.images.size());
  LONGS_EQUAL(3, training.applied.size());
  CHECK_COMPARE(training.model.p2_max, >, 2.345);
  CHECK_COMPARE(training.model.p2_min, >, 2.225);
}

TEST(TrainingReview, NamesTheDistancesThatNoRecordingShows) {
  Training training;
  training.recordings = {"rec"};
  training.model = Trained(), training.images = images_;  // all 200 px long: 25 m
  const auto stretches = UncoveredDistances(training);
  LONGS_EQUAL(2, stretches.size());
  STRCMP_EQUAL("5 to 23.5 m", stretches[0].c_str());
  STRCMP_EQUAL("30.3 to 110 m", stretches[1].c_str());
}

TEST(TrainingReview, DoubtsTheTargetFileWhenManyImagesNearlyFit) {
  for (std::size_t i = 0; i < 20; ++i) {
    images_[3 * i].hits = {Hit(2.25)};
    images_[3 * i].hits[0].within_noise = false;
  }
  Training training;
  training.recordings = {"rec"};
  training.model = Trained(), training.images = images_;
  training.review = ReviewImages(training.model, training.images, kNoisePx);
  const std::string page = MakeTrainReport(training).Html();
  STRCMP_CONTAINS("20 images show a bar", page.c_str());
  STRCMP_CONTAINS("(p2 2.25, as built 2.2707): measure leds_m again", page.c_str());

  // Leaving them out does not make the target file right.
  ApplyMends({}, training);
  CHECK(training.review.problems.empty());
  STRCMP_CONTAINS("20 images show a bar", MakeTrainReport(training).Html().c_str());
}

TEST(TrainingReview, IsToldOnOnePage) {
  images_[12].hits = {Hit(2.345)};
  Training training;
  training.recordings = {"rec<1>"};
  training.model = Trained(), training.images = images_;
  training.review = ReviewImages(training.model, training.images, kNoisePx);
  training.others.push_back({Trained(), std::nullopt});
  const auto page = MakeTrainReport(training);
  STRCMP_CONTAINS("rec&lt;1&gt;", page.Html().c_str());
  STRCMP_CONTAINS("can be confused with &#39;bar&#39; in one image at any distance", page.Html().c_str());
  STRCMP_CONTAINS("\"timestamp_ns\": \"1012\"", page.Json().c_str());
  CHECK(page.Html().find("nan") == std::string::npos);
}
