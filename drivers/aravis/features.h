// GenICam features under the names that cameras have given them.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string_view>

namespace adit::aravis {

/// How a feature's value is written.
enum class ValueKind : std::uint8_t { kFloat, kInteger };

struct FeatureName {
  const char* name;
  ValueKind kind;
};

/// Exposure time in us: SFNC 2, SFNC 1, and cameras that only count microseconds.
inline constexpr std::array<FeatureName, 3> kExposureNames{{{"ExposureTime", ValueKind::kFloat},
                                                            {"ExposureTimeAbs", ValueKind::kFloat},
                                                            {"ExposureTimeRaw", ValueKind::kInteger}}};
/// Gain in dB; raw steps have no unit and are left alone.
inline constexpr std::array<FeatureName, 2> kGainNames{
    {{"Gain", ValueKind::kFloat}, {"GainAbs", ValueKind::kFloat}}};
/// State of the camera's clock in PTP, and what switches PTP on.
inline constexpr std::array<const char*, 2> kPtpStatusNames{"PtpStatus", "GevIEEE1588Status"};
inline constexpr std::array<const char*, 2> kPtpEnableNames{"PtpEnable", "GevIEEE1588"};

/// The first of `names` that `available` knows, or nullptr.
template <class Names>
const typename Names::value_type* FirstAvailable(const Names& names,
                                                 const std::function<bool(const char*)>& available) {
  for (const auto& name : names) {
    if constexpr (requires { name.name; }) {
      if (available(name.name)) return &name;
    } else {
      if (available(name)) return &name;
    }
  }
  return nullptr;
}

/// Whether a PTP state means that the camera's time is the network's.
inline bool PtpStateIsLocked(std::string_view state) { return state == "Slave" || state == "Master"; }

}  // namespace adit::aravis
