#include "host/demo_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <vector>

#include "drivers/linux/system_clock.h"

namespace adit::host {
namespace {

// The plan: 0 to 110 m ahead, 8 m to either side of the rig's axis.
constexpr int kPlanColumns = 74, kPlanRows = 9;
constexpr double kPlanDepthM = 110, kPlanHalfWidthM = 9;

template <class... Values>
std::string Text(const char* format, Values... values) {
  std::array<char, 256> line{};
  std::snprintf(line.data(), line.size(), format, values...);
  return line.data();
}

std::string Paint(bool colour, const char* code, const std::string& text) {
  return colour ? "\033[" + std::string(code) + "m" + text + "\033[0m" : text;
}

std::vector<ShownTarget> Shown(DemoStage& stage) {
  std::vector<ShownTarget> shown;
  const base::TimeNs now_ns = linux::SystemClock().Now();
  for (std::size_t i = 0; i < stage.Targets().size(); ++i) {
    publish::CanReceiver& receiver = stage.Bus()[i].Receiver();
    ShownTarget target;
    target.name = stage.Targets()[i];
    target.good = receiver.Good(now_ns) && receiver.OffsetMetres();
    if (target.good) target.position_m = *receiver.OffsetMetres();
    shown.push_back(target);
  }
  return shown;
}

/// Seen from above: the rig at the left edge, the tunnel to the right.
std::string Plan(const std::vector<ShownTarget>& targets, bool colour) {
  std::vector<std::string> rows(kPlanRows, std::string(kPlanColumns, ' '));
  for (std::string& edge : {std::ref(rows.front()), std::ref(rows.back())}) edge.assign(kPlanColumns, '-');
  rows[1][0] = 'L';
  rows[kPlanRows - 2][0] = 'R';
  for (const ShownTarget& target : targets) {
    if (!target.good) continue;
    const double across =
        (target.position_m[0] - 4.5) / kPlanHalfWidthM;  // the rig's middle is 4.5 m right of cam0
    const int row = static_cast<int>(std::lround((across + 1) / 2 * (kPlanRows - 1)));
    const int column = static_cast<int>(std::lround(target.position_m[2] / kPlanDepthM * (kPlanColumns - 1)));
    rows[static_cast<std::size_t>(std::clamp(row, 1, kPlanRows - 2))]
        [static_cast<std::size_t>(std::clamp(column, 1, kPlanColumns - 1))] = target.name.back();
  }
  std::string text;
  for (const std::string& row : rows) {
    std::string line = "  ";
    for (const char c : row) {
      const bool mark = c != ' ' && c != '-' && c != 'L' && c != 'R';
      line += mark ? Paint(colour, "1;32", std::string(1, c)) : std::string(1, c);
    }
    text += line + "\n";
  }
  return text + "  0 m             20 m          40 m          60 m          80 m          100 m\n";
}

}  // namespace

std::string DrawDemo(DemoStage& stage, double elapsed_s, double total_s, bool colour) {
  const StatusWords& status = stage.Status();
  const auto word = [&status](const std::string& key) {
    const auto found = status.find(key);
    return found == status.end() ? std::string("-") : found->second;
  };
  const std::vector<ShownTarget> targets = Shown(stage);
  std::string text = Paint(colour, "1", "adit") +
                     Text("  two simulated GigE Vision cameras -> aditd -> CAN, Modbus   %.0f / %.0f s\n\n",
                          elapsed_s, total_s);
  text += Plan(targets, colour) + "\n";
  for (const ShownTarget& target : targets) {
    text += Text("  %-10s ", target.name.c_str());
    text += target.good ? Paint(colour, "32",
                                Text("x %8.3f   y %8.3f   z %8.3f m", target.position_m[0],
                                     target.position_m[1], target.position_m[2]))
                        : Paint(colour, "31", "no position");
    text += "\n";
  }
  text += "\n  state      " + word("state") + "   faults " + word("faults") +
          "   (bit 5: no georeference in the demo)\n";
  text +=
      "  pairs      " + word("pairs") + "   " + word("rate_hz") + " /s   unpaired " + word("unpaired") + "\n";
  text += "  detection  " + word("detect_ms") + " ms   location " + word("locate_ms") + " ms   (p50/p99)\n";
  text += "  latency    trigger to result " + word("trigger_to_result_ms") + " ms   last packet to result " +
          word("packet_to_result_ms") + " ms   to bus " + word("packet_to_bus_ms") + " ms\n";
  text += "  cameras    missed " + word("left.missed") + " + " + word("right.missed") + "   incomplete " +
          word("left.incomplete") + " + " + word("right.incomplete") + "\n";
  text += "  CAN        " + word("can_frames") + " frames, " + word("can_dropped") +
          " epochs dropped     Modbus clients " + word("modbus_clients") + "\n";
  text += Text("  processor  aditd %.2f cores   simulated cameras %.2f cores\n", stage.DaemonCores(),
               stage.CameraCores());
  return text;
}

std::string DemoLine(DemoStage& stage, double elapsed_s) {
  std::string text = Text("%5.1f s", elapsed_s);
  for (const ShownTarget& target : Shown(stage)) {
    text += "  " + target.name +
            (target.good ? Text(" (%.3f, %.3f, %.3f) m", target.position_m[0], target.position_m[1],
                                target.position_m[2])
                         : std::string(" no position"));
  }
  const auto rate = stage.Status().find("rate_hz");
  return text + "  " + (rate == stage.Status().end() ? "-" : rate->second) + " pairs/s\n";
}

}  // namespace adit::host
