#include "firmware/publish/dbc.h"

#include <array>
#include <cstdio>
#include <string_view>

#include "firmware/publish/e2e.h"
#include "firmware/publish/signal_table.h"

namespace adit::publish {
namespace {

constexpr int kCycleMs = 50;
constexpr std::string_view kSender = "ADIT";
constexpr std::string_view kReceiver = "PLC";

// printf into a string; a line of a DBC is short.
template <class... Args>
std::string Line(const char* format, Args... args) {
  std::array<char, 256> line;
  std::snprintf(line.data(), line.size(), format, args...);
  return line.data();
}

struct DbcSignal {
  std::string name;
  std::string multiplexer;  ///< "", " M" or " m3"
  int start = 0;
  int bits = 0;
  bool is_signed = false;
  double scale = 1;
  std::string unit;
};

std::string FormatSignal(const DbcSignal& s) {
  const double span = static_cast<double>(std::uint64_t{1} << s.bits);
  const double low = s.is_signed ? -span / 2 : 0;
  // 10 digits hold every 32-bit number in steps of 0.0001 exactly.
  std::string text = " SG_ " + s.name + s.multiplexer + " : ";
  text += Line("%d|%d@1%c (%.10g,0) [%.10g|%.10g]", s.start, s.bits, s.is_signed ? '-' : '+', s.scale,
               low * s.scale, (low + span - 1) * s.scale);
  return text + " \"" + s.unit + "\" " + std::string(kReceiver) + "\n";
}

unsigned IdOf(const CanSlot& slot, std::uint8_t node) { return slot.id_base + 0U + node + slot.node_offset; }

std::string FormatInfoSignals() {
  std::string text = FormatSignal({"InfoIndex", " M", 0, 8, false, 1, ""});
  int index = 0;
  for (const InfoRow& row : InfoRows()) {
    text += FormatSignal({std::string("Info") + row.name, " m" + std::to_string(index++), 8, 32,
                          IsSigned(row.type), 1, row.unit});
  }
  return text;
}

std::string FormatMessage(const CanSlot& slot, std::uint8_t node) {
  const std::string name = slot.name;
  std::string text = Line("BO_ %u ADIT_%s: 8 ", IdOf(slot, node), slot.name) + std::string(kSender) + "\n";
  if (slot.slot == kInfoSlot) {
    text += FormatInfoSignals();
  } else {
    for (const SignalRow& row : Signals()) {
      if (row.can.bits == 0 || row.can.slot != slot.slot) continue;
      text += FormatSignal(
          {row.name, "", row.can.start_bit, row.can.bits, IsSigned(row.type), row.scale, row.unit});
    }
    text += FormatSignal({name + "_Validity", "", 32, 2, false, 1, ""});
    text += FormatSignal({name + "_Age", "", 34, 6, false, 4, "ms"});
  }
  text += FormatSignal({name + "_CRC", "", 40, 16, false, 1, ""});
  text += FormatSignal({name + "_Epoch", "", 56, 8, false, 1, ""});
  return text + "\n";
}

// INFO speaks for boxes whose ids leave it room.
bool Present(const CanSlot& slot, std::uint8_t node) {
  return slot.slot != kInfoSlot || node <= kInfoNodeMax;
}

std::string FormatAttributes(const CanSlot& slot, std::uint8_t node) {
  const unsigned id = IdOf(slot, node);
  const unsigned data_id = DataId(node, slot.slot);
  return Line("BA_ \"GenMsgCycleTime\" BO_ %u %d;\n", id, slot.slot == kInfoSlot ? 2 * kCycleMs : kCycleMs) +
         Line("BA_ \"E2EProfile\" BO_ %u 5;\n", id) + Line("BA_ \"E2EDataID\" BO_ %u %u;\n", id, data_id) +
         Line("BA_ \"E2EOffset\" BO_ %u 40;\n", id);
}

}  // namespace

std::string FormatDbc(std::uint8_t node) {
  std::string text =
      Line("VERSION \"adit-can 1.0 node 0x%02X\"\n\nNS_ :\n\nBS_:\n\nBU_: ", static_cast<unsigned>(node));
  text += std::string(kSender) + " " + std::string(kReceiver) + "\n\n";
  for (const CanSlot& slot : CanSlots()) {
    if (Present(slot, node)) text += FormatMessage(slot, node);
  }
  text +=
      "BA_DEF_ BO_ \"GenMsgCycleTime\" INT 0 10000;\nBA_DEF_ BO_ \"E2EProfile\" INT 0 99;\n"
      "BA_DEF_ BO_ \"E2EDataID\" INT 0 65535;\nBA_DEF_ BO_ \"E2EOffset\" INT 0 512;\n";
  text += Line("BA_DEF_DEF_ \"GenMsgCycleTime\" %d;\n", kCycleMs);
  text += "BA_DEF_DEF_ \"E2EProfile\" 0;\nBA_DEF_DEF_ \"E2EDataID\" 0;\nBA_DEF_DEF_ \"E2EOffset\" 0;\n";
  for (const CanSlot& slot : CanSlots()) {
    if (Present(slot, node)) text += FormatAttributes(slot, node);
  }
  for (const CanSlot& slot : CanSlots()) {
    if (slot.slot == kInfoSlot) continue;
    text += Line("VAL_ %u %s_Validity", IdOf(slot, node), slot.name);
    text += " 3 \"SIMULATED\" 2 \"DEGRADED\" 1 \"VALID\" 0 \"INVALID\" ;\n";
  }
  text += Line("VAL_ %u State", IdOf(*FindCanSlot(kStatusSlot), node));
  text +=
      " 7 \"SIMULATION\" 6 \"FAULT\" 5 \"SERVICE\" 4 \"LOST\" 3 \"DEGRADED\" 2 \"TRACK\" 1 \"SEARCH\" 0 "
      "\"INIT\" ;\n";
  return text;
}

}  // namespace adit::publish
