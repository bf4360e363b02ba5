#include "host/serve.h"

#include <arpa/inet.h>
#include <poll.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <iostream>
#include <memory>
#include <sstream>

#include "drivers/linux/atomic_file.h"
#include "drivers/linux/signals.h"
#include "drivers/linux/system_clock.h"
#include "drivers/sim/gige_camera.h"
#include "drivers/sim/live_scene.h"
#include "host/failure.h"

namespace adit::host {
namespace {

constexpr base::DurationNs kLookNs = 50 * base::kNsPerMs;
constexpr base::DurationNs kLeadNs = base::kNsPerS / 2;  // from starting to trigger 0
constexpr int kAheadMax = 1000;                          // 2.9 GB of two cameras

struct ServeOptions {
  std::string scene, left = "127.0.0.1", right = "127.0.0.2", truth;
  double seconds = 0;       ///< 0: until a signal
  std::uint64_t ahead = 0;  ///< frames rendered before the start and served again and again; 0: none
};

/// Frames of one side, rendered ahead: serving them costs a copy.
class FramesAhead {
 public:
  FramesAhead(sim::LiveScene& scene, base::Side side, std::uint64_t count) : bytes_(scene.FrameBytes(side)) {
    pixels_.resize(count * bytes_);
    for (std::uint64_t i = 0; i < count; ++i) scene.Render(side, i, pixels_.data() + i * bytes_);
  }
  void Copy(std::uint64_t trigger, std::uint8_t* pixels) const {
    const std::uint64_t count = pixels_.size() / bytes_;
    std::copy_n(pixels_.data() + trigger % count * bytes_, bytes_, pixels);
  }

 private:
  std::size_t bytes_;
  std::vector<std::uint8_t> pixels_;
};

base::Result<std::uint32_t> AddressOf(const std::string& text) {
  in_addr address{};
  if (inet_pton(AF_INET, text.c_str(), &address) == 1) return ntohl(address.s_addr);
  return base::Error{base::ErrorCode::kUsage, "--left, --right", "'" + text + "' is no IPv4 address"};
}

/// Both cameras of a scene behind one trigger.
class CameraPair {
 public:
  static base::Result<std::unique_ptr<CameraPair>> Start(const ServeOptions& options) {
    auto scene = sim::LiveScene::Open(options.scene, sim::NoiseSource::kBank);
    if (!scene) return scene.error();
    std::unique_ptr<CameraPair> pair(new CameraPair(std::move(*scene)));
    for (const base::Side side : {base::Side::kLeft, base::Side::kRight}) {
      if (options.ahead > 0) pair->ahead_.emplace_back(*pair->scene_, side, options.ahead);
    }
    pair->trigger_.start_ns = linux::SystemClock().Now() + kLeadNs;
    pair->trigger_.period_ns = static_cast<base::DurationNs>(
        std::llround(static_cast<double>(base::kNsPerS) / pair->scene_->GetScene().rate_hz));
    for (const base::Side side : {base::Side::kLeft, base::Side::kRight}) {
      const auto address = AddressOf(side == base::Side::kLeft ? options.left : options.right);
      if (!address) return address.error();
      if (auto started = pair->Add(side, *address); !started) return started.error();
    }
    return pair;
  }

  sim::GigeCamera& Camera(base::Side side) { return *cameras_[static_cast<std::size_t>(side)]; }
  const sim::TriggerClock& Trigger() const { return trigger_; }

  /// The truth of all triggers up to now, dated as the cameras dated them.
  std::string Truth() const {
    const base::TimeNs now_ns = linux::SystemClock().Now();
    std::string text = sim::TruthHeader();
    for (std::uint64_t trigger = 0; trigger_.EdgeNs(trigger) < now_ns; ++trigger) {
      std::vector<sim::TruthRow> rows = scene_->Truth(trigger);
      for (sim::TruthRow& row : rows) row.mid_exposure_ns = trigger_.EdgeNs(trigger) + ExposureNs() / 2;
      text += sim::FormatTruth(rows);
    }
    return text;
  }
  std::uint64_t Late() const { return cameras_[0]->FramesLate() + cameras_[1]->FramesLate(); }

 private:
  explicit CameraPair(std::unique_ptr<sim::LiveScene> scene) : scene_(std::move(scene)) {}

  base::DurationNs ExposureNs() const {
    return static_cast<base::DurationNs>(
        std::llround(scene_->GetScene().exposure_s * static_cast<double>(base::kNsPerS)));
  }
  base::Result<void> Add(base::Side side, std::uint32_t address) {
    sim::GigeOptions options;
    options.identity.serial = side == base::Side::kLeft ? "SIM-LEFT" : "SIM-RIGHT";
    options.identity.address = address;
    options.identity.width_px = scene_->WidthPx(side);
    options.identity.height_px = scene_->HeightPx(side);
    options.trigger = trigger_;
    options.exposure_ns = ExposureNs();
    options.frame_bytes = scene_->FrameBytes(side);
    cameras_.push_back(
        std::make_unique<sim::GigeCamera>(options, [this, side](std::uint64_t trigger, std::uint8_t* pixels) {
          if (ahead_.empty()) return scene_->Render(side, trigger, pixels);
          ahead_[static_cast<std::size_t>(side)].Copy(trigger, pixels);
        }));
    return cameras_.back()->Start();
  }

  std::unique_ptr<sim::LiveScene> scene_;
  std::vector<FramesAhead> ahead_;  ///< left, right; empty: each frame is rendered when it is due
  sim::TriggerClock trigger_;
  std::vector<std::unique_ptr<sim::GigeCamera>> cameras_;  // after the scene: their threads end before it
};

/// "left vanish", "right lose 0.01", ...: what a camera is to do wrong. Says when it did, and what it did not
/// understand.
void Obey(const std::string& line, CameraPair& pair) {
  std::istringstream in(line);
  std::string side, verb;
  double value = 0;
  in >> side >> verb >> value;
  if (side != "left" && side != "right") {
    std::cerr << "adit serve: '" << line << "': begin with left or right\n";
    return;
  }
  sim::GigeFaults& faults = pair.Camera(side == "left" ? base::Side::kLeft : base::Side::kRight).Faults();
  bool understood = true;
  if (verb == "vanish") {
    faults.vanished = true;
  } else if (verb == "return") {
    faults.vanished = false;
  } else if (verb == "stall" || verb == "resume") {
    faults.stall = verb == "stall";
  } else if (verb == "lose") {
    faults.loss = value;
  } else if (verb == "drop") {
    faults.drop_frames += 1;
  } else if (verb == "truncate") {
    faults.truncate_frames += 1;
  } else {
    understood = false;
    std::cerr << "adit serve: '" << verb
              << "' is none of vanish, return, stall, resume, lose SHARE, drop, truncate\n";
  }
  if (understood) std::cout << "did_ns " << linux::SystemClock().Now() << " " << line << std::endl;
}

/// Takes a line from stdin if one is there; false once stdin has ended.
bool TakeCommand(CameraPair& pair) {
  pollfd in{STDIN_FILENO, POLLIN, 0};
  if (poll(&in, 1, 0) <= 0) return true;
  std::string line;
  if (!std::getline(std::cin, line)) return false;
  if (!line.empty()) Obey(line, pair);
  return true;
}

int RunServe(const ServeOptions& options, linux::StopSignals& signals) {
  auto pair = CameraPair::Start(options);
  if (!pair) return Fail("serve", pair.error());
  std::cout << "trigger0_ns " << (*pair)->Trigger().start_ns << "\nserving" << std::endl;
  const std::int64_t start_ns = linux::MonotonicNs();
  const auto limit_ns = static_cast<std::int64_t>(options.seconds * static_cast<double>(base::kNsPerS));
  bool listening = true;
  while (!signals.WaitFor(kLookNs) && (limit_ns == 0 || linux::MonotonicNs() - start_ns < limit_ns)) {
    listening = listening && TakeCommand(**pair);
  }
  if (!options.truth.empty()) {
    if (auto done = linux::WriteFileAtomically(options.truth, (*pair)->Truth()); !done)
      return Fail("serve", done.error());
  }
  if ((*pair)->Late() > 0) std::cout << "late " << (*pair)->Late() << std::endl;
  return 0;
}

}  // namespace

void AddServe(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("serve", "a scene as two simulated GigE Vision cameras");
  auto options = std::make_shared<ServeOptions>();
  command->add_option("SCENE", options->scene, "scene file")->required();
  command->add_option("--left", options->left, "IPv4 address of the left camera");
  command->add_option("--right", options->right, "IPv4 address of the right camera");
  command->add_option("--truth", options->truth, "file for the truth, written at the end");
  command->add_option("--seconds", options->seconds, "how long; until a signal if not given")
      ->check(CLI::NonNegativeNumber);
  command->add_option("--ahead", options->ahead, "render so many frames first and serve these in turn")
      ->check(CLI::Range(0, kAheadMax))
      ->excludes("--truth");
  command->callback([options, &exit_code] {
    linux::StopSignals signals;  // before any thread starts
    exit_code = RunServe(*options, signals);
  });
}

}  // namespace adit::host
