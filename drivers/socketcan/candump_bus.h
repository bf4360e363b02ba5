// A field bus that is a file: every frame becomes a line of the log format of candump -L, which canplayer,
// canmatrix and python-can read.
#pragma once

#include <memory>
#include <string>

#include "firmware/base/result.h"
#include "hal/clock.h"
#include "hal/field_bus.h"

namespace adit::socketcan {

/// For kernels without CAN, and for looking at what would go out. Honest: a frame counts as sent when its
/// line was handed to the kernel. Lines of one epoch are written at once, so that a reader who follows the
/// file never sees half of one.
class CandumpBus final : public hal::FieldBus {
 public:
  /// Appends to `path`, made if absent; `channel` is the name in the lines. Declines with the file. `clock`
  /// dates the lines and must outlive the bus.
  static base::Result<std::unique_ptr<CandumpBus>> Open(const std::string& path, const std::string& channel,
                                                        const hal::Clock& clock);
  ~CandumpBus() override;
  CandumpBus(const CandumpBus&) = delete;
  CandumpBus& operator=(const CandumpBus&) = delete;

  /// Frames of one epoch; those of all targets of a box may come together (32 targets of 11 frames).
  static constexpr std::size_t kMaxEpochFrames = 352;

  /// kDropped when the file takes no more (disk full), kSent otherwise.
  hal::SendOutcome SendEpoch(std::span<const base::CanFrame> frames) override;
  void Poll(base::TimeNs now_ns) override;
  hal::FieldBusHealth Health() const override { return health_; }

 private:
  CandumpBus(int file, std::string channel, const hal::Clock& clock);

  int file_;
  std::string channel_;
  const hal::Clock& clock_;
  hal::FieldBusHealth health_;
};

}  // namespace adit::socketcan
