#include <cmath>
#include <iomanip>
#include <sstream>

#include "host/comparison.h"

namespace adit::host {
namespace {

/// Two decimals; nothing was measured: a dash.
std::string Shown(double value) {
  if (!std::isfinite(value)) return "-";
  std::ostringstream text;
  text << std::fixed << std::setprecision(2) << value;
  return text.str();
}

/// JSON knows no NaN.
std::string Json(double value) {
  if (!std::isfinite(value)) return "null";
  std::ostringstream text;
  text << std::setprecision(9) << value;
  return text.str();
}

}  // namespace

std::string FormatTable(const Comparison& comparison) {
  std::ostringstream text;
  text << "target           distance_m  visible  tracked_%   rms_mm   max_mm      bias_mm (x y z)    nees"
          "  bar_mae_mm  bar_xrms_mm  flips\n"
       << std::fixed;
  for (const Figures& f : comparison.figures) {
    std::ostringstream range;
    range << std::fixed << std::setprecision(0) << f.from_m << "-" << f.to_m;
    text << std::left << std::setw(16) << f.target << std::right << std::setw(11) << range.str()
         << std::setw(9) << f.visible << std::setprecision(2) << std::setw(11) << f.TrackedPct()
         << std::setw(9) << Shown(f.rms_m * 1e3) << std::setw(9) << Shown(f.max_m * 1e3) << std::setw(7)
         << Shown(f.bias_m.x() * 1e3) << std::setw(7) << Shown(f.bias_m.y() * 1e3) << std::setw(7)
         << Shown(f.bias_m.z() * 1e3) << std::setw(8) << Shown(f.nees) << std::setw(12)
         << Shown(f.bar_mae_m * 1e3) << std::setw(13) << Shown(f.bar_xrms_m * 1e3) << std::setw(7) << f.flips
         << "\n";
  }
  text << "false positions: " << comparison.false_positions << "\n";
  return text.str();
}

std::string FormatJson(const Comparison& comparison) {
  std::ostringstream text;
  text << std::setprecision(9) << "{\n  \"false_positions\": " << comparison.false_positions
       << ",\n  \"figures\": [";
  const char* separator = "\n";
  for (const Figures& f : comparison.figures) {
    // A target's name holds no quotes or line ends: the target file is refused otherwise.
    text << separator << "    {\"target\": \"" << f.target << "\", \"from_m\": " << f.from_m
         << ", \"to_m\": " << f.to_m << ", \"visible\": " << f.visible << ", \"tracked\": " << f.tracked
         << ", \"recovered\": " << f.recovered << ", \"hidden\": " << f.hidden
         << ", \"tracked_pct\": " << f.TrackedPct() << ", \"rms_m\": " << Json(f.rms_m)
         << ", \"max_m\": " << Json(f.max_m) << ", \"bias_m\": [" << Json(f.bias_m.x()) << ", "
         << Json(f.bias_m.y()) << ", " << Json(f.bias_m.z()) << "], \"nees\": " << Json(f.nees)
         << ", \"bar_mae_m\": " << Json(f.bar_mae_m) << ", \"bar_xrms_m\": " << Json(f.bar_xrms_m)
         << ", \"flips\": " << f.flips << "}";
    separator = ",\n";
  }
  text << "\n  ]\n}\n";
  return text.str();
}

}  // namespace adit::host
