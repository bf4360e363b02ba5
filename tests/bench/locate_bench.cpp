// What identification and location cost against the number of blobs, with two targets in view.
#include <benchmark/benchmark.h>

#include <memory>

#include "firmware/identify/identifier.h"
#include "firmware/stereo/locator.h"
#include "tests/support/synthetic_bar.h"

namespace {

using adit::support::SyntheticBar;

constexpr double kNoisePx = 0.05;
constexpr int kScenes = 16;  // in turn, so that no branch is learnt by heart

/// Two bars and lamps up to the given number of blobs, and what searches them with models that were trained
/// from `nearest_m` on: the nearer, the longer a bar's image may be, the more pairs of blobs may be one.
struct Bench {
  Bench(int blobs, int nearest_m) {
    const auto rig = adit::support::ToedInRig();
    const std::vector<adit::base::Target> targets{adit::support::SeedTargetOne(),
                                                  adit::support::SeedTargetTwo()};
    std::vector<adit::identify::Model> models;
    for (const auto& target : targets) models.push_back(adit::support::ModelOf(target, nearest_m));
    adit::identify::IdentifierOptions options;
    options.focal_px = rig.left.f_px;
    identifier = std::make_unique<adit::identify::Identifier>(models, options);
    locator = std::make_unique<adit::stereo::Locator>(rig.AsRig(), targets);
    for (int i = 0; i < kScenes; ++i) {
      adit::support::SyntheticScene scene(rig, static_cast<unsigned>(i));
      scene.AddBar(SyntheticBar::At(targets[0], adit::support::Ahead(rig, 30), {1, 0.2, 0.3}), kNoisePx);
      scene.AddBar(SyntheticBar::At(targets[1], adit::support::Ahead(rig, 45), {0.2, 1, -0.5}), kNoisePx);
      scene.AddLamps(blobs - 8, kNoisePx);
      scene.Shuffle();
      scenes.push_back(scene.Blobs());
    }
  }
  const adit::support::BlobPair& Next() { return scenes[turn++ % scenes.size()]; }

  std::unique_ptr<adit::identify::Identifier> identifier;
  std::unique_ptr<adit::stereo::Locator> locator;
  std::vector<adit::support::BlobPair> scenes;
  std::size_t turn = 0;
  std::unique_ptr<adit::identify::SightingSet> left = std::make_unique<adit::identify::SightingSet>();
  std::unique_ptr<adit::identify::SightingSet> right = std::make_unique<adit::identify::SightingSet>();
  std::unique_ptr<adit::stereo::PointSet> points = std::make_unique<adit::stereo::PointSet>();
};

void SearchTwoTargets(benchmark::State& state) {
  Bench bench(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
  double sightings = 0;
  for (auto _ : state) {
    bench.identifier->Identify(bench.Next().left, *bench.left);
    sightings += static_cast<double>(bench.left->sightings.size());
  }
  state.counters["sightings"] = benchmark::Counter(sightings, benchmark::Counter::kAvgIterations);
}

void LocateTwoTargets(benchmark::State& state) {
  Bench bench(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
  double tracked = 0;
  for (auto _ : state) {
    const auto& blobs = bench.Next();
    bench.identifier->Identify(blobs.left, *bench.left);
    bench.right->blob_set = &blobs.right;
    bench.locator->Locate(*bench.left, *bench.right, *bench.points);
    for (const auto& p : bench.points->targets)
      tracked += p.status == adit::stereo::FixStatus::kTracked ? 0.5 : 0;
  }
  state.counters["tracked"] = benchmark::Counter(tracked, benchmark::Counter::kAvgIterations);
}

}  // namespace

BENCHMARK(SearchTwoTargets)
    ->ArgNames({"blobs", "nearest_m"})
    ->ArgsProduct({{12, 30, 60, 120, 200, 400}, {5, 20}})
    ->Unit(benchmark::kMicrosecond);
BENCHMARK(LocateTwoTargets)
    ->ArgNames({"blobs", "nearest_m"})
    ->ArgsProduct({{12, 30, 60, 120, 200, 400}, {5, 20}})
    ->Unit(benchmark::kMicrosecond);
BENCHMARK_MAIN();
