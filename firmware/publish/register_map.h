// Epoch -> the registers of Modbus map 1.0.
#pragma once

#include <array>
#include <cstdint>

#include "firmware/base/latest.h"
#include "firmware/publish/box_record.h"

namespace adit::publish {

inline constexpr std::uint16_t kMapVersion = 0x0100;
inline constexpr std::uint16_t kLiveFirst = 100;
inline constexpr std::uint16_t kLiveLength = 42;
inline constexpr std::uint16_t kTargetsFirst = 1000;
inline constexpr std::uint16_t kTargetLength = 20;
inline constexpr std::uint16_t kRegisterEnd = kTargetsFirst + kTargetLength * identify::kMaxTargets;
inline constexpr std::uint16_t kDiscreteInputs = 16;

/// Whether all of [first, first + count) exist. The areas between the blocks of the map do not.
bool RegistersExist(unsigned first, unsigned count);

/// All registers at one moment. Values stand high word first; addresses that do not exist hold 0.
struct RegisterImage {
  std::array<std::uint16_t, kRegisterEnd> words{};
  std::uint16_t discrete_inputs = 0;  ///< bit i: FC02 address i
};

/// One target, as its struct tells it.
struct TargetRecord {
  Epoch epoch;
  std::uint8_t id = 0;      ///< place in the model list from 1; 0: no such target
  std::uint8_t status = 0;  ///< 1 tracked, 2 recovered, 3 predicted, 4 lost
  double residual_px = 0;
  base::TimeNs last_seen_ns = base::kNever;
};

/// What a RegisterMap hands from its writer to its readers.
struct RegisterSnapshot {
  Epoch epoch;
  BoxHealth health;
  base::TimeNs updated_ns = base::kNever;
  std::array<TargetRecord, identify::kMaxTargets> targets{};
};

/// What the box was told last. One writer, any number of readers, none of which waits.
class RegisterMap {
 public:
  RegisterMap(const BoxIdentity& identity, const EpochRules& rules) : identity_(identity), rules_(rules) {}

  /// Publisher thread, every cycle: `leading` is the epoch of the live block, `fixes` fill the target
  /// structs by the same rules (MakeEpoch) under `box`. No heap.
  void Update(const Epoch& leading, const BoxCondition& box, const BoxHealth& health,
              const georef::GeoFixSet& fixes, base::TimeNs now_ns);

  /// Any thread: one whole epoch, ages and validity as of `now_ns`. No heap. Before the first Update
  /// everything is INIT and INVALID.
  void Read(base::TimeNs now_ns, RegisterImage& out) const;

  const BoxIdentity& Identity() const { return identity_; }

 private:
  BoxIdentity identity_;
  EpochRules rules_;
  base::Latest<RegisterSnapshot> latest_;
};

}  // namespace adit::publish
