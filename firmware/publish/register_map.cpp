#include "firmware/publish/register_map.h"

#include <algorithm>

#include "firmware/publish/crc16.h"
#include "firmware/publish/signal_table.h"

namespace adit::publish {
namespace {

// After this without an Update the publisher counts as dead.
constexpr base::DurationNs kAliveLimitNs = base::kNsPerS;

void Put(RegisterImage& image, unsigned address, WireType type, std::int64_t raw) {
  const unsigned words = WordsOf(type);
  const auto bits = static_cast<std::uint64_t>(raw);
  for (unsigned i = 0; i < words; ++i) {
    image.words[address + i] = static_cast<std::uint16_t>((bits >> (16 * (words - 1 - i))) & 0xFFFFU);
  }
}

void PutLabel(RegisterImage& image, unsigned address, const Label& label) {
  for (unsigned i = 0; i < label.size() / 2; ++i) {
    const auto high = static_cast<unsigned char>(label[2 * i]);
    const auto low = static_cast<unsigned char>(label[2 * i + 1]);
    image.words[address + i] = static_cast<std::uint16_t>(high * 256U + low);
  }
}

// Over the registers before it as they go over the wire, high byte first, and the data id, low byte first.
std::uint16_t LiveCrc(const RegisterImage& image) {
  std::uint16_t crc = kCrc16Start;
  for (unsigned address = kLiveFirst; address < kLiveCrcAddress; ++address) {
    const std::array<std::uint8_t, 2> bytes{static_cast<std::uint8_t>(image.words[address] >> 8),
                                            static_cast<std::uint8_t>(image.words[address] & 0xFFU)};
    crc = Crc16(bytes, crc);
  }
  constexpr std::array<std::uint8_t, 2> kId{kLiveDataId & 0xFFU, kLiveDataId >> 8};
  return Crc16(kId, crc);
}

std::uint8_t StatusNumber(stereo::FixStatus status) {
  switch (status) {
    case stereo::FixStatus::kTracked:
      return 1;
    case stereo::FixStatus::kRecovered:
      return 2;
    case stereo::FixStatus::kPredicted:
      return 3;
    case stereo::FixStatus::kLost:
      break;
  }
  return 4;
}

}  // namespace

bool RegistersExist(unsigned first, unsigned count) {
  return std::ranges::any_of(RegisterAreas(), [&](const RegisterArea& area) {
    return first >= area.first && first + count <= static_cast<unsigned>(area.first) + area.count;
  });
}

void RegisterMap::Update(const Epoch& leading, const BoxCondition& box, const BoxHealth& health,
                         const georef::GeoFixSet& fixes, base::TimeNs now_ns) {
  RegisterSnapshot snapshot;
  snapshot.epoch = leading;
  snapshot.health = health;
  snapshot.updated_ns = now_ns;
  for (std::size_t i = 0; i < fixes.targets.size(); ++i) {
    const georef::GeoFix& fix = fixes.targets[i];
    TargetRecord& target = snapshot.targets[i];
    target.epoch = MakeEpoch(&fix, box, rules_, now_ns);
    target.id = static_cast<std::uint8_t>(i + 1);
    target.status = StatusNumber(fix.state.points.status);
    target.residual_px = fix.state.points.reprojection_px;
    target.last_seen_ns = fix.state.last_seen_ns;
  }
  latest_.Store(snapshot);
}

void RegisterMap::Read(base::TimeNs now_ns, RegisterImage& out) const {
  const RegisterSnapshot snapshot = latest_.Load();
  out = RegisterImage{};
  const bool alive = snapshot.updated_ns != base::kNever && now_ns - snapshot.updated_ns <= kAliveLimitNs;
  const BoxRecord record{AsOf(snapshot.epoch, now_ns), snapshot.health, identity_, now_ns, alive};
  for (const SignalRow& row : Signals()) {
    if (row.address) Put(out, *row.address, row.type, row.raw(record));
  }
  out.words[kLiveCrcAddress] = LiveCrc(out);
  for (const LabelRow& row : LabelRows()) PutLabel(out, row.address, identity_.*row.text);
  for (std::size_t i = 0; i < snapshot.targets.size(); ++i) {
    TargetRecord target = snapshot.targets[i];
    target.epoch = AsOf(target.epoch, now_ns);
    const unsigned base = kTargetsFirst + kTargetLength * static_cast<unsigned>(i);
    for (const TargetRow& row : TargetRows()) Put(out, base + row.offset, row.type, row.raw(target, now_ns));
  }
  for (std::size_t i = 0; i < BitRows().size(); ++i) {
    if (BitRows()[i].on(record)) out.discrete_inputs |= static_cast<std::uint16_t>(1U << i);
  }
}

}  // namespace adit::publish
