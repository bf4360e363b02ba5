#include "host/simulate.h"

#include <filesystem>

#include "drivers/recording/recording.h"
#include "drivers/sim/truth_file.h"
#include "firmware/identify/model.h"
#include "firmware/optics/rig.h"
#include "tests/support/small_scene.h"

#include <CppUTest/TestHarness.h>

using adit::base::ErrorCode;
using adit::host::Simulate;
using adit::host::SimulateOrder;
using adit::tests::ReadAll;
using adit::tests::ScratchFolder;

namespace {

namespace fs = std::filesystem;

struct SmallSimulation {
  ScratchFolder scratch;
  SimulateOrder order;

  SmallSimulation() {
    order.scene = scratch.Write("scene.yaml", adit::tests::kSmallRig + "frames: 3\ntargets: [{" +
                                                  adit::tests::kBarKeys + ", at_m: [0, 0, 20]}]\n");
    order.out = scratch / "rec";
  }
  /// The files in the scratch folder, one a line.
  std::string Listing() const {
    std::string listing;
    for (const auto& entry : fs::directory_iterator(scratch / "."))
      listing += entry.path().filename().string() + "\n";
    return listing;
  }
};

}  // namespace

TEST_GROUP(Simulate){};

TEST(Simulate, WritesARecordingThatCarriesItsTruth) {
  const SmallSimulation small;
  CHECK_TRUE(static_cast<bool>(Simulate(small.order)));

  const auto recording = adit::recording::OpenRecording(small.order.out);
  CHECK_TRUE(static_cast<bool>(recording));
  LONGS_EQUAL(3, recording->left.size());
  LONGS_EQUAL(3, recording->right.size());
  LONGS_EQUAL(320, adit::recording::ReadImage(recording->right[2].path)->width_px);
  const auto truth = adit::sim::ReadTruth(small.order.out + "/truth.csv");
  LONGS_EQUAL(3, truth->size());
  LONGLONGS_EQUAL(recording->left[2].mid_exposure_ns, truth->at(2).mid_exposure_ns);
  const auto rig = adit::optics::LoadRig(small.order.out + "/rig_true.yaml");
  DOUBLES_EQUAL(1, rig->BaselineM(), 1e-12);
  LONGS_EQUAL(320, adit::optics::LoadCamera(small.order.out + "/cam1/sensor.yaml")->width_px);
  STRCMP_EQUAL("bar", adit::identify::LoadTarget(small.order.out + "/target_bar.yaml")->name.c_str());
}

TEST(Simulate, GivesTheSameBytesForTheSameOrderAndOthersForAnotherSeed) {
  SmallSimulation small;
  const auto image_of = [&small](const std::string& name, std::optional<std::uint64_t> seed) {
    small.order.out = small.scratch / name;
    small.order.seed = seed;
    CHECK_TRUE(static_cast<bool>(Simulate(small.order)));
    const auto recording = adit::recording::OpenRecording(small.order.out);
    return ReadAll(recording->right[1].path);
  };
  const std::string first = image_of("a", std::nullopt);
  CHECK_TRUE(first == image_of("b", std::nullopt));
  CHECK_FALSE(first == image_of("c", 99));
}

TEST(Simulate, RendersAsManyFramesAsAsked) {
  SmallSimulation small;
  small.order.frames = 2;
  small.order.out += "/";
  fs::create_directory(small.order.out);  // empty: may be taken
  CHECK_TRUE(static_cast<bool>(Simulate(small.order)));
  LONGS_EQUAL(2, adit::recording::OpenRecording(small.order.out)->left.size());
  STRCMP_CONTAINS("rec\n", small.Listing().c_str());
}

TEST(Simulate, RefusesAFolderThatHoldsSomethingAndLeavesItAlone) {
  const SmallSimulation small;
  small.scratch.Write("rec/notes.txt", "mine");
  const auto done = Simulate(small.order);
  CHECK_FALSE(static_cast<bool>(done));
  CHECK_TRUE(done.error().code == ErrorCode::kUsage);
  STRCMP_CONTAINS("rec: exists and is not an empty folder", done.error().Line().c_str());
  STRCMP_EQUAL("mine", ReadAll(small.scratch / "rec/notes.txt").c_str());
}

TEST(Simulate, LeavesNothingBehindWhenItFails) {
  SmallSimulation small;
  small.order.scene = small.scratch.Write("scene.yaml", adit::tests::kSmallRig + "rate_hz: -1\n");
  CHECK_FALSE(static_cast<bool>(Simulate(small.order)));
  STRCMP_EQUAL("scene.yaml\n", small.Listing().c_str());
  // A file stands where the folder above should be.
  small.order.scene = small.scratch.Write("scene.yaml", adit::tests::kSmallRig + "frames: 1\n");
  small.order.out = small.scratch / "scene.yaml/rec";
  const auto done = Simulate(small.order);
  CHECK_FALSE(static_cast<bool>(done));
  STRCMP_EQUAL("scene.yaml\n", small.Listing().c_str());
}
