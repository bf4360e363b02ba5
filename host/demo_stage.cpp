#include "host/demo_stage.h"

#include <filesystem>
#include <sstream>

#include "drivers/linux/atomic_file.h"
#include "drivers/linux/system_clock.h"
#include "drivers/sim/scene.h"
#include "firmware/identify/model.h"
#include "firmware/optics/rig.h"
#include "host/training.h"

namespace adit::host {
namespace {

constexpr const char* kLeftAddress = "127.0.0.1";
constexpr const char* kRightAddress = "127.0.0.2";
constexpr int kModbusPort = 1502;  // above 1024: nobody needs to be root
constexpr std::uint8_t kNode = 0x20;
constexpr base::DurationNs kStartLimitNs = 30 * base::kNsPerS;
constexpr base::DurationNs kStopGraceNs = 5 * base::kNsPerS;

/// The folder of the running program, where aditd lies too.
std::string ProgramFolder() { return std::filesystem::read_symlink("/proc/self/exe").parent_path().string(); }

/// Waits for a line that starts with `word`.
base::Result<std::string> WaitForLine(linux::Process& process, const std::string& name,
                                      const std::string& word) {
  const std::int64_t limit_ns = linux::MonotonicNs() + kStartLimitNs;
  while (linux::MonotonicNs() < limit_ns) {
    const auto line = process.ReadLine(base::kNsPerS);
    if (line && line->rfind(word, 0) == 0) return *line;
    if (process.OutputEnded()) break;
  }
  return base::Error{base::ErrorCode::kFailed, name, "did not start; its messages are above"};
}

std::string BoxFile(const std::vector<std::string>& targets, double rate_hz, double exposure_s) {
  std::ostringstream text;
  text << "# The demo's box. `adit config schema` explains every key.\nserial: demo\nsimulation: true\nrig: "
          "rig.yaml\nmodels: [";
  for (std::size_t i = 0; i < targets.size(); ++i)
    text << (i == 0 ? "" : ", ") << "model_" << targets[i] << ".yaml";
  text << "]\ncameras:\n  left: {device: " << kLeftAddress << "}\n  right: {device: " << kRightAddress
       << "}\n  rate_hz: " << rate_hz << "\n  exposure_us: " << exposure_s * 1e6
       << "\npublish:\n  can: {driver: candump, log: can.log, node: " << static_cast<int>(kNode)
       << "}\n  modbus: {enabled: true, bind: 127.0.0.1, port: " << kModbusPort
       << "}\ntrack_log: track.csv\nhealth_report: health.yaml\n";
  return text.str();
}

}  // namespace

StatusWords ParseStatus(const std::string& line) {
  StatusWords words;
  std::istringstream in(line);
  for (std::string word; in >> word;) {
    const std::size_t equals = word.find('=');
    words[word.substr(0, equals)] = equals == std::string::npos ? "" : word.substr(equals + 1);
  }
  return words;
}

double NumberOf(const StatusWords& words, const std::string& key, int part) {
  const auto word = words.find(key);
  if (word == words.end()) return 0;
  const std::size_t slash = word->second.find('/');
  const std::string text = part == 0 ? word->second.substr(0, slash)
                                     : (slash == std::string::npos ? "" : word->second.substr(slash + 1));
  return std::strtod(text.c_str(), nullptr);
}

base::Result<std::unique_ptr<DemoStage>> DemoStage::Start(const DemoOptions& options) {
  std::unique_ptr<DemoStage> stage(new DemoStage(options));
  if (auto files = stage->WriteFiles(); !files) return files.error();
  if (auto cameras = stage->StartCameras(); !cameras) return cameras.error();
  if (auto daemon = stage->StartDaemon(); !daemon) return daemon.error();
  auto plc = Plc::Connect("127.0.0.1", kModbusPort);
  if (!plc) return plc.error();
  stage->plc_.emplace(std::move(*plc));
  if (auto identity = stage->plc_->CheckIdentity(); !identity) return identity.error();
  stage->started_ns_ = linux::MonotonicNs();
  return stage;
}

base::Result<void> DemoStage::WriteFiles() {
  const auto scene = sim::LoadScene(options_.scene);
  if (!scene) return scene.error();
  std::error_code failed;
  std::filesystem::remove_all(options_.folder, failed);
  std::filesystem::create_directories(options_.folder, failed);
  if (failed)
    return base::Error{base::ErrorCode::kUnavailable, options_.folder, "cannot be made: " + failed.message()};
  const auto write = [this](const std::string& file, const std::string& text) {
    return linux::WriteFileAtomically(Path(file), text);
  };
  if (auto done = write("rig.yaml", optics::FormatRig(scene->rig)); !done) return done;
  for (const sim::SceneTarget& target : scene->targets) {
    const identify::Model model = GeometryModel(target.target, {});
    targets_.push_back(target.target.name);
    if (auto done = write("model_" + target.target.name + ".yaml", identify::FormatModel(model)); !done)
      return done;
    bus_.emplace_back(Path("can.log"), static_cast<std::uint8_t>(kNode + 2 * bus_.size()));
  }
  return write("box.yaml", BoxFile(targets_, scene->rate_hz, scene->exposure_s));
}

base::Result<void> DemoStage::StartCameras() {
  auto cameras =
      linux::Process::Spawn({ProgramFolder() + "/adit", "serve", options_.scene, "--left", kLeftAddress,
                             "--right", kRightAddress, "--truth", Path("truth.csv")});
  if (!cameras) return cameras.error();
  cameras_.emplace(std::move(*cameras));
  const auto serving = WaitForLine(*cameras_, "the simulated cameras", "serving");
  return serving ? base::Result<void>() : serving.error();
}

base::Result<void> DemoStage::StartDaemon() {
  auto daemon = linux::Process::Spawn({ProgramFolder() + "/aditd", "--config", Path("box.yaml"), "--status"});
  if (!daemon) return daemon.error();
  daemon_.emplace(std::move(*daemon));
  const auto running = WaitForLine(*daemon_, "aditd", "running");
  return running ? base::Result<void>() : running.error();
}

base::Result<void> DemoStage::Poll() {
  while (const auto line = daemon_->ReadLine(0)) {
    if (line->rfind("status ", 0) == 0) status_ = ParseStatus(*line);
  }
  while (cameras_->ReadLine(0)) {
  }
  for (BusReader& bus : bus_) bus.Follow();
  if (daemon_->WaitFor(0))
    return base::Error{base::ErrorCode::kFailed, "aditd", "ended early; its messages are above"};
  if (cameras_->WaitFor(0)) {
    return base::Error{base::ErrorCode::kFailed, "the simulated cameras",
                       "ended early; their messages are above"};
  }
  return {};
}

void DemoStage::Stop() {
  if (daemon_) {
    daemon_->Terminate(kStopGraceNs);
    while (const auto line = daemon_->ReadLine(0)) {
      if (line->rfind("status ", 0) == 0) status_ = ParseStatus(*line);
    }
  }
  if (cameras_) cameras_->Terminate(kStopGraceNs);
  for (BusReader& bus : bus_) bus.Follow();
}

double DemoStage::DaemonCores() const {
  return static_cast<double>(daemon_->CpuNs()) / static_cast<double>(linux::MonotonicNs() - started_ns_);
}

double DemoStage::CameraCores() const {
  return static_cast<double>(cameras_->CpuNs()) / static_cast<double>(linux::MonotonicNs() - started_ns_);
}

}  // namespace adit::host
