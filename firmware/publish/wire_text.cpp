#include "firmware/publish/wire_text.h"

#include <array>
#include <cstdio>

#include "firmware/publish/signal_table.h"

namespace adit::publish {
namespace {

constexpr const char* kWritten =
    "<!-- Written from the signal table (firmware/publish/signal_table.cpp); a test compares. Do not edit. "
    "-->\n\n";

const char* NameOf(WireType type) {
  switch (type) {
    case WireType::kU16:
      return "u16";
    case WireType::kI16:
      return "i16";
    case WireType::kU32:
      return "u32";
    case WireType::kI32:
      return "i32";
    case WireType::kF32:
      return "f32";
    case WireType::kF64:
      break;
  }
  return "f64";
}

template <class Number>
std::string Text(const char* format, Number number) {
  std::array<char, 32> text;
  std::snprintf(text.data(), text.size(), format, number);
  return text.data();
}

std::string Absent(WireType type, const std::optional<std::int64_t>& raw) {
  if (!raw) return "";
  const bool wide = WordsOf(type) == 2;
  return wide ? Text("0x%08X", static_cast<unsigned>(*raw & 0xFFFFFFFF))
              : Text("0x%04X", static_cast<unsigned>(*raw & 0xFFFF));
}

std::string Step(double scale, const std::string& unit) {
  if (unit.empty()) return scale == 1 ? "" : Text("%.10g", scale);
  return Text("%.10g ", scale) + unit;
}

std::string Row(std::initializer_list<std::string> cells) {
  std::string row = "|";
  for (const std::string& cell : cells) row += " " + cell + " |";
  return row + "\n";
}

std::string FormatFaults() {
  std::string text = "## Fault bits\n\n| bit | fault |\n| --- | --- |\n";
  int bit = 0;
  for (const char* name : FaultNames()) text += Row({std::to_string(bit++), name});
  return text;
}

std::string FormatRegisters() {
  std::string text =
      "| address | name | type | step | not available | meaning |\n| --- | --- | --- | --- | --- | --- |\n";
  for (const SignalRow& row : Signals()) {
    if (!row.address) continue;
    text += Row({std::to_string(*row.address), row.name, NameOf(row.type), Step(row.scale, row.unit),
                 Absent(row.type, row.not_available), row.meaning});
    // The CRC is of the block, not of the box: it has no row of its own.
    if (*row.address + 1 == kLiveCrcAddress) {
      text += Row({std::to_string(kLiveCrcAddress), "LiveCrc", "u16", "", "",
                   "CRC-16/CCITT-FALSE over 100-140 as sent, then the bytes FF A0"});
    }
  }
  return text + "\n";
}

std::string FormatTargets() {
  std::string text = "## Target structs: 1000 + 20 i, i = 0 to 31\n\n";
  text +=
      "| offset | name | type | step | not available | meaning |\n| --- | --- | --- | --- | --- | --- |\n";
  for (const TargetRow& row : TargetRows()) {
    text += Row({std::to_string(row.offset), row.name, NameOf(row.type), Step(row.scale, row.unit),
                 Absent(row.type, row.not_available), row.meaning});
  }
  return text + "\n";
}

std::string FormatCanSignals() {
  std::string text = "| slot | id | frame | signal | bits | step | not available | meaning |\n";
  text += "| --- | --- | --- | --- | --- | --- | --- | --- |\n";
  for (const CanSlot& slot : CanSlots()) {
    std::string id = Text("0x%03X + n", static_cast<unsigned>(slot.id_base));
    if (slot.node_offset != 0) id += " + 1";
    for (const SignalRow& row : Signals()) {
      if (row.can.bits == 0 || row.can.slot != slot.slot) continue;
      const int last = row.can.start_bit + row.can.bits - 1;
      text += Row({std::to_string(slot.slot), id, slot.name, row.name,
                   std::to_string(row.can.start_bit) + "-" + std::to_string(last), Step(row.scale, row.unit),
                   Absent(row.type, row.not_available), row.meaning});
    }
  }
  return text + "\n";
}

std::string FormatInfo() {
  std::string text = "| index | name | type | unit | meaning |\n| --- | --- | --- | --- | --- |\n";
  int index = 0;
  for (const InfoRow& row : InfoRows()) {
    text += Row({std::to_string(index++), row.name, NameOf(row.type), row.unit, row.meaning});
  }
  return text + "\n";
}

}  // namespace

std::string FormatCanDocument() {
  std::string text = "# adit-CAN 1.0\n\n";
  text += kWritten;
  text +=
      "Node n (0x20 by default; the next target or body takes n + 2), 11-bit ids, 8 bytes, little-endian, "
      "one epoch each\n"
      "cycle (50 ms by default). `docs/adit-can.dbc` says the same for node 0x20.\n\n"
      "| byte | field |\n| --- | --- |\n"
      "| 0-3 | the value, below |\n"
      "| 4, bits 0-1 | validity: 0 INVALID, 1 VALID, 2 DEGRADED, 3 SIMULATED (must never move a machine) |\n"
      "| 4, bits 2-7 | age x 4 ms, rounded up, from mid-exposure to hand-over; 63: 252 ms or more, or "
      "unknown |\n"
      "| 5-6 | CRC-16/CCITT-FALSE over bytes 0-4, 7, then DataID low, high (AUTOSAR E2E profile 5, offset 40 "
      "bit) |\n"
      "| 7 | counter: the same in all frames of an epoch, +1 each epoch, 255 -> 0 |\n\n"
      "DataID = 0xA000 + 16 n + slot. Coordinates are differences from the origin E0, N0, H0 (INFO), whole "
      "metres.\n"
      "Every cycle is sent in every state; without a position it is INVALID and `not available`.\n"
      "Frames go out in the order of their slots but STATUS, which is last: the epoch is complete. Slots 9 "
      "to 14 (block B)\n"
      "come with an alignment; this version sends none.\n\n";
  text += FormatCanSignals();
  text +=
      "## INFO: slot 8, id 0x680 + n, n up to 0x5F; never for control\n\n"
      "Byte 0 index, bytes 1-4 the number: so it has no validity and no age. CRC and counter as in every "
      "frame. One index\n"
      "every 100 ms, in turn.\n\n";
  text += FormatInfo();
  text +=
      "## Service frames (CiA 301)\n\n"
      "Heartbeat 0x700 + n every 200 ms: first 0x00 (boot-up), then 0x05 (operational). EMCY 0x080 + n "
      "whenever the fault\n"
      "bits change: error code 0xFF00 and register 0x80, or zeros when no fault is left; bytes 3-4 the fault "
      "bits.\n\n"
      "## The interface on the box\n\nAn epoch is handed over at once: two targets are more frames than the "
      "10 that an interface queues by default. "
      "`ip link set can0 txqueuelen 1000` before the daemon starts; a full queue is fault bit 8.\n\n"
      "## The receiver's rule\n\n"
      "Accept an epoch if the CRC holds, the counter moved by 1 to 3, validity is VALID, the age is within "
      "100 ms, and the\n"
      "counters of POS_E, POS_N and POS_H are equal. 150 ms without an accepted epoch: safe reaction. Back "
      "after three good\n"
      "epochs in a row. The very first epoch only sets the counter.\n\n";
  return text + FormatFaults();
}

std::string FormatModbusDocument() {
  std::string text = "# Modbus map 1.0\n\n";
  text += kWritten;
  text +=
      "TCP. FC04 and FC03 read the same registers; 0-based addresses; high word first (`mbpoll -B`). "
      "Registers 4 to 8 never\n"
      "change and show a wrong word order in a minute. FC02 reads the bits, FC43/14 who the box is. One read "
      "is one epoch: ages\n"
      "and validity are of the moment of the answer, so read the live block 100-141 in one request. Unit: "
      "the own, 0 or 255;\n"
      "others get exception 0x0B. Exceptions: 01 function (writes are off), 03 length or count, 02 address. "
      "Steps give the\n"
      "value of one count. The areas between those below do not exist (exception 02); reserved registers in "
      "them read 0.\n\n"
      "| first | registers | content |\n| --- | --- | --- |\n";
  for (const RegisterArea& area : RegisterAreas()) {
    text += Row({std::to_string(area.first), std::to_string(area.count), area.content});
  }
  text += "\n## Registers\n\n" + FormatRegisters();
  text +=
      "## Texts: 16 registers, two ASCII characters each, zero padded\n\n| address | name |\n| --- | --- |\n";
  for (const LabelRow& row : LabelRows()) text += Row({std::to_string(row.address), row.name});
  text += "\n" + FormatTargets();
  text += "## Discrete inputs (FC02)\n\n| address | name | 1 means |\n| --- | --- | --- |\n";
  int bit = 0;
  for (const BitRow& row : BitRows()) text += Row({std::to_string(bit++), row.name, row.meaning});
  return text + "\n" + FormatFaults();
}

}  // namespace adit::publish
