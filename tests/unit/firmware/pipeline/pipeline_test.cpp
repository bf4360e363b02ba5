#include "firmware/pipeline/pipeline.h"

#include <memory>

#include "tests/support/allocation_guard.h"
#include "tests/support/synthetic_bar.h"

#include <CppUTest/TestHarness.h>

using adit::identify::Model;
using adit::pipeline::PairResult;
using adit::pipeline::Pipeline;
using adit::stereo::FixStatus;
using adit::support::ModelOf;
using adit::support::SyntheticBar;
using adit::support::SyntheticScene;

namespace {

std::string Complaint(const std::vector<Model>& models) {
  const auto pipeline = Pipeline::Make(adit::support::ToedInRig().AsRig(), models, {});
  return pipeline ? "" : pipeline.error().Line();
}

}  // namespace

TEST_GROUP(Pipeline) {
  adit::support::SyntheticRig rig = adit::support::ToedInRig();
  std::unique_ptr<SyntheticScene> scene = std::make_unique<SyntheticScene>(rig, 5);
  std::unique_ptr<PairResult> result = std::make_unique<PairResult>();
  std::vector<Model> models{ModelOf(adit::support::SeedTargetOne()), ModelOf(adit::support::SeedTargetTwo())};
};

TEST(Pipeline, TurnsBlobsIntoFixesInModelOrder) {
  auto pipeline = Pipeline::Make(rig.AsRig(), models, {});
  CHECK(!!pipeline);
  const auto bar = SyntheticBar::At(adit::support::SeedTargetTwo(), Ahead(rig, 45), {1, 0.3, -0.2});
  CHECK(scene->AddBar(bar, 0.02));
  scene->AddLamps(60, 0.02);
  scene->Shuffle();
  pipeline->Locate(scene->Blobs().left, scene->Blobs().right, *result);
  LONGS_EQUAL(2, result->fixes.targets.size());
  CHECK_FALSE(result->fixes.georeferenced);
  CHECK(result->fixes.targets[0].state.points.status == FixStatus::kLost);
  const auto& fix = result->fixes.targets[1];
  CHECK(fix.state.points.status == FixStatus::kTracked);
  CHECK((fix.position_s_m - bar.Epicenter()).norm() < 0.01);
  CHECK(fix.state.mid_exposure_ns == scene->Blobs().left.stamp.mid_exposure_ns);
}

TEST(Pipeline, PutsFixesOnTheSiteGridWhenTold) {
  adit::georef::AbsoluteOrientation orientation;
  orientation.T_s_b.rotation << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  orientation.T_s_b.translation_m = {2600000, 1200000, 400};
  adit::pipeline::PipelineOptions options;
  options.georeference = adit::georef::Georeference(orientation);
  auto pipeline = Pipeline::Make(rig.AsRig(), models, options);
  CHECK(!!pipeline);
  const auto bar = SyntheticBar::At(adit::support::SeedTargetTwo(), Ahead(rig, 45), {1, 0.3, -0.2});
  CHECK(scene->AddBar(bar, 0.02));
  pipeline->Locate(scene->Blobs().left, scene->Blobs().right, *result);
  CHECK(result->fixes.georeferenced);
  const Eigen::Vector3d at_b_m = bar.Epicenter();
  const Eigen::Vector3d at_s_m(2600000 + at_b_m.x(), 1200000 + at_b_m.z(), 400 - at_b_m.y());
  CHECK((result->fixes.targets[1].position_s_m - at_s_m).norm() < 0.01);
}

TEST(Pipeline, ReportsEveryTargetLostWhenAFrameIsMissing) {
  auto pipeline = Pipeline::Make(rig.AsRig(), models, {});
  CHECK(!!pipeline);
  scene->Blobs().left.stamp.status = adit::base::FrameStatus::kIncomplete;
  pipeline->Locate(scene->Blobs().left, scene->Blobs().right, *result);
  LONGS_EQUAL(2, result->fixes.targets.size());
  for (const auto& fix : result->fixes.targets)
    CHECK(fix.state.points.reason == adit::stereo::LossReason::kNoFrame);
}

TEST(Pipeline, GivesTheSameAnswerEveryTime) {
  auto pipeline = Pipeline::Make(rig.AsRig(), models, {});
  CHECK(!!pipeline);
  CHECK(scene->AddBar(SyntheticBar::At(adit::support::SeedTargetOne(), Ahead(rig, 30), {1, 0, 0}), 0.02));
  scene->AddLamps(100, 0.02);
  pipeline->Locate(scene->Blobs().left, scene->Blobs().right, *result);
  const Eigen::Vector3d first = result->fixes.targets[0].position_s_m;
  CHECK(first.norm() > 1);
  for (int i = 0; i < 5; ++i) {
    pipeline->Locate(scene->Blobs().left, scene->Blobs().right, *result);
    CHECK(result->fixes.targets[0].position_s_m == first);
  }
}

TEST(Pipeline, LocatesWithoutAllocating) {
  if (!adit::support::CountsAllocations()) return;
  auto pipeline = Pipeline::Make(rig.AsRig(), models, {});
  CHECK(!!pipeline);
  CHECK(scene->AddBar(SyntheticBar::At(adit::support::SeedTargetOne(), Ahead(rig, 30), {1, 0, 0}), 0.02));
  scene->AddLamps(300, 0.02);
  const auto before = adit::support::AllocationCount();
  for (int i = 0; i < 10; ++i) pipeline->Locate(scene->Blobs().left, scene->Blobs().right, *result);
  LONGS_EQUAL(before, adit::support::AllocationCount());
  CHECK(result->fixes.targets[0].state.points.status == FixStatus::kTracked);
}

TEST(Pipeline, RefusesModelListsThatCannotWork) {
  STRCMP_EQUAL("", Complaint(models).c_str());
  STRCMP_CONTAINS("there are 0", Complaint({}).c_str());
  STRCMP_CONTAINS("there are 33", Complaint(std::vector<Model>(33, models[0])).c_str());
  STRCMP_CONTAINS("named one", Complaint({models[0], models[0]}).c_str());
}

TEST(Pipeline, RefusesTwoBarsThatLookAlike) {
  Model twin = models[0];
  twin.target.name = "twin";
  STRCMP_CONTAINS("one and twin", Complaint({models[0], twin}).c_str());
  for (std::size_t i = 0; i < 4; ++i) twin.target.leds_m[i] = 1.5 - models[0].target.leds_m[3 - i];
  STRCMP_CONTAINS("told apart", Complaint({models[0], twin}).c_str());
  for (double& led_m : twin.target.leds_m) led_m *= 0.9;
  STRCMP_EQUAL("", Complaint({models[0], twin}).c_str());
}
