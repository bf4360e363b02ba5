// The address space of a simulated camera: bootstrap registers, its own ones, and the GenICam description of
// both.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drivers/sim/gige_protocol.h"

namespace adit::sim {

/// How a camera names its exposure time; they differ by maker and age.
enum class ExposureName : std::uint8_t { kExposureTime, kExposureTimeAbs, kExposureTimeRaw };

/// What a simulated camera says of itself.
struct GigeIdentity {
  std::string serial = "SIM0";
  std::uint32_t address = 0x7F000001;  ///< IPv4, host order
  int width_px = 1400, height_px = 1024;
  ExposureName exposure = ExposureName::kExposureTime;
};

/// Addresses that the camera itself looks at (GigE Vision 2.0, chapter 28; from 0x10000 on our own).
inline constexpr std::uint32_t kRegHeartbeatMs = 0x0938, kRegControl = 0x0A00, kRegStreamPort = 0x0D00,
                               kRegPacketSize = 0x0D04, kRegStreamAddress = 0x0D18;
inline constexpr std::uint32_t kRegWidth = 0x10000, kRegHeight = 0x10004, kRegPixelFormat = 0x10008,
                               kRegAcquisition = 0x1000C, kRegTriggerMode = 0x10010,
                               kRegTriggerSource = 0x10014, kRegPtpEnable = 0x10018, kRegPtpStatus = 0x1001C,
                               kRegPayload = 0x10020, kRegExposure = 0x10030, kRegGain = 0x10038,
                               kRegExposureRaw = 0x10040;

/// Pixel formats by the Pixel Format Naming Convention.
inline constexpr std::uint32_t kMono8 = 0x01080001, kMono10 = 0x01100003, kMono12 = 0x01100005;

/// Big-endian memory with the rules of who may write where. One thread.
class GigeRegisters {
 public:
  explicit GigeRegisters(const GigeIdentity& identity);

  /// Declines addresses outside of it.
  std::optional<std::span<const std::uint8_t>> Read(std::uint32_t address, std::size_t bytes) const;
  std::optional<std::uint32_t> ReadWord(std::uint32_t address) const;
  /// Whole words on word boundaries.
  GvcpStatus Write(std::uint32_t address, std::span<const std::uint8_t> bytes);
  /// The camera's own writes.
  void Set(std::uint32_t address, std::uint32_t value);

 private:
  void SetText(std::uint32_t address, const std::string& text, std::size_t room);
  std::vector<std::uint8_t> memory_;
};

/// The GenICam XML of such a camera.
std::string GigeXml(const GigeIdentity& identity);

}  // namespace adit::sim
