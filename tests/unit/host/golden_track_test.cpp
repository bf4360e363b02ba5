// A short recording, simulated from tests/data/golden/scene.yaml and tracked, against the committed track.
// When a change of the stages moves positions on purpose: look at what `adit diff` says, then make the track
// anew from the root of the tree:
//   adit simulate tests/data/golden/scene.yaml --out rec
//   adit train --target tests/data/golden/bar_c.yaml --camera rec/cam0/sensor.yaml --out c.yaml  (bar_d
//   likewise) adit track --recording rec --rig rec/rig_true.yaml --model c.yaml --model d.yaml --out
//   tests/data/golden/track.csv
#include <filesystem>
#include <iostream>

#include "host/replay.h"
#include "host/simulate.h"
#include "host/track_difference.h"
#include "host/training.h"
#include "tests/support/scratch_folder.h"

#include <CppUTest/TestHarness.h>

namespace {

const std::string kFolder = "tests/data/golden/";

/// The model of a target file, as `adit train` makes it for the recording's camera.
std::string WriteModel(const adit::tests::ScratchFolder& scratch, const std::string& name) {
  const auto target = *adit::identify::LoadTarget(kFolder + name + ".yaml");
  adit::host::TrainingOptions options;
  options.focal_px = 800;
  return scratch.Write(name + "_model.yaml", FormatModel(adit::host::GeometryModel(target, options)));
}

std::string TrackGolden() {
  const adit::tests::ScratchFolder scratch;
  const auto simulated = adit::host::Simulate({kFolder + "scene.yaml", scratch / "rec", {}, {}});
  CHECK_FALSE(!simulated);
  adit::host::ReplayOrder order;
  order.recording = scratch / "rec", order.rig = scratch / "rec/rig_true.yaml";
  order.models = {WriteModel(scratch, "bar_c"), WriteModel(scratch, "bar_d")};
  const auto track = adit::host::ReplayRecording(order);
  CHECK_FALSE(!track);
  return track->text;
}

}  // namespace

TEST_GROUP(GoldenTrack){};

TEST(GoldenTrack, IsBitForBitTheSameFromRunToRun) {
  STRCMP_EQUAL(TrackGolden().c_str(), TrackGolden().c_str());
}

TEST(GoldenTrack, IsTheCommittedOne) {
  constexpr double kToleranceM = 1e-6;  // the last digit of a track; libm may round otherwise elsewhere
  const auto golden = *adit::pipeline::LoadTrack(kFolder + "track.csv");
  const auto track = *adit::pipeline::ParseTrack(TrackGolden(), "tracked now");
  const auto difference = adit::host::CompareTracks(golden, track);
  if (!difference.Same(kToleranceM)) std::cout << adit::host::FormatDifferenceTable(difference);
  LONGS_EQUAL(2, difference.targets.size());
  CHECK(difference.targets[0].both >= 10);  // a golden track of nothing proves nothing
  CHECK(difference.Same(kToleranceM));
}
