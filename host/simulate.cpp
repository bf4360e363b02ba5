#include "host/simulate.h"

#include <atomic>
#include <filesystem>
#include <memory>
#include <random>
#include <thread>
#include <vector>

#include "drivers/linux/atomic_file.h"
#include "drivers/recording/recording.h"
#include "drivers/sim/live_scene.h"
#include "firmware/identify/model.h"
#include "firmware/optics/rig.h"
#include "host/failure.h"
#include "host/progress.h"

namespace adit::host {
namespace {

namespace fs = std::filesystem;
using base::Error;
using base::ErrorCode;

/// A folder that is gone at the end unless it was given its name.
class PartialFolder {
 public:
  explicit PartialFolder(const std::string& out) : out_(fs::path(out).lexically_normal()) {
    if (!out_.has_filename()) out_ = out_.parent_path();  // "rec/"
    part_ = out_;
    part_ += ".part" + std::to_string(std::random_device{}());
  }
  ~PartialFolder() {
    std::error_code ignored;
    fs::remove_all(part_, ignored);
  }
  PartialFolder(const PartialFolder&) = delete;
  PartialFolder& operator=(const PartialFolder&) = delete;

  const fs::path& Path() const { return part_; }

  base::Result<void> CheckFree() const {
    std::error_code ignored;
    if (fs::exists(out_, ignored) && !(fs::is_directory(out_, ignored) && fs::is_empty(out_, ignored)))
      return Error{ErrorCode::kUsage, out_.string(),
                   "exists and is not an empty folder; --out needs a new one"};
    return {};
  }
  base::Result<void> GiveName() {
    std::error_code fault;
    fs::rename(part_, out_, fault);
    if (fault) return Error{ErrorCode::kUnavailable, out_.string(), "cannot be made: " + fault.message()};
    return {};
  }

 private:
  fs::path out_, part_;
};

/// All frames of one side; stops early when the other side has failed.
base::Result<void> RenderSide(base::Side side, sim::LiveScene& scene, recording::RecordingWriter& writer,
                              std::atomic<bool>& failed, Progress* progress) {
  std::vector<std::uint8_t> pixels(scene.FrameBytes(side));
  const base::ImageView view{pixels.data(), scene.WidthPx(side), scene.HeightPx(side),
                             scene.WidthPx(side) * (scene.Bits() > 8 ? 2 : 1), scene.Bits()};
  const auto frames = static_cast<std::uint64_t>(scene.GetScene().frames);
  for (std::uint64_t trigger = 0; trigger < frames; ++trigger) {
    // relaxed: a request to stop, nothing is published through it.
    if (failed.load(std::memory_order_relaxed)) return {};
    scene.Render(side, trigger, pixels.data());
    auto written = writer.Write(side, scene.GetWorld().MidExposureNs(trigger), view);
    if (!written) {
      failed.store(true, std::memory_order_relaxed);
      return written;
    }
    if (progress != nullptr) progress->Step();
  }
  return {};
}

base::Result<void> RenderBoth(sim::LiveScene& scene, recording::RecordingWriter& writer) {
  Progress progress("rendering", static_cast<std::size_t>(scene.GetScene().frames));
  std::atomic<bool> failed{false};
  base::Result<void> right;
  std::thread right_thread([&] { right = RenderSide(base::Side::kRight, scene, writer, failed, nullptr); });
  const base::Result<void> left = RenderSide(base::Side::kLeft, scene, writer, failed, &progress);
  right_thread.join();
  return left ? right : left;
}

base::Result<void> WriteTruth(const sim::LiveScene& scene, const fs::path& folder) {
  std::string truth = sim::TruthHeader();
  for (long trigger = 0; trigger < scene.GetScene().frames; ++trigger)
    truth += sim::FormatTruth(scene.Truth(static_cast<std::uint64_t>(trigger)));
  if (auto written = linux::WriteFileAtomically(folder / "truth.csv", truth); !written) return written;
  const std::string rig = optics::FormatRig(scene.GetScene().rig);
  if (auto written = linux::WriteFileAtomically(folder / "rig_true.yaml", rig); !written) return written;
  for (const sim::SceneTarget& target : scene.GetScene().targets) {
    const fs::path path = folder / ("target_" + target.target.name + ".yaml");
    if (auto written = linux::WriteFileAtomically(path, identify::FormatTarget(target.target)); !written)
      return written;
  }
  return {};
}

int RunSimulate(const SimulateOrder& order) {
  const auto done = Simulate(order);
  return done ? 0 : Fail("simulate", done.error());
}

}  // namespace

base::Result<void> Simulate(const SimulateOrder& order) {
  PartialFolder folder(order.out);
  if (auto ready = folder.CheckFree(); !ready) return ready;
  auto loaded = sim::LoadScene(order.scene, order.seed);
  if (!loaded) return loaded.error();
  if (order.frames) loaded->frames = *order.frames;
  sim::LiveScene scene(std::move(*loaded), sim::NoiseSource::kFresh);
  auto writer =
      recording::RecordingWriter::Create(folder.Path(), optics::FormatCamera(scene.GetScene().rig.left),
                                         optics::FormatCamera(scene.GetScene().rig.right));
  if (!writer) return writer.error();
  if (auto rendered = RenderBoth(scene, *writer); !rendered) return rendered;
  if (auto finished = writer->Finish(); !finished) return finished;
  if (auto written = WriteTruth(scene, folder.Path()); !written) return written;
  return folder.GiveName();
}

void AddSimulate(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("simulate", "a recording with truth from a described scene");
  auto order = std::make_shared<SimulateOrder>();
  command->add_option("SCENE", order->scene, "scene file (its keys: drivers/sim/scene.h)")->required();
  command->add_option("--out", order->out, "folder to make")->required();
  command->add_option("--frames", order->frames, "instead of the scene's")
      ->check(CLI::Range(1L, 10'000'000L));
  command->add_option("--seed", order->seed, "instead of the scene's");
  command->callback([order, &exit_code] { exit_code = RunSimulate(*order); });
}

}  // namespace adit::host
