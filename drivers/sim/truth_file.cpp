#include "drivers/sim/truth_file.h"

#include <charconv>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <string_view>

namespace adit::sim {
namespace {

using base::Error;
using base::ErrorCode;

constexpr std::size_t kCells = 22;

/// Splits one line and turns its cells into numbers; keeps the first mistake.
class TruthCells {
 public:
  explicit TruthCells(std::string_view line) {
    for (std::size_t from = 0; from <= line.size();) {
      const std::size_t comma = std::min(line.find(',', from), line.size());
      cells_.push_back(line.substr(from, comma - from));
      from = comma + 1;
    }
    if (cells_.size() != kCells)
      fault_ = "has " + std::to_string(cells_.size()) + " cells; it must have " + std::to_string(kCells);
  }

  template <class T>
  T Number() {
    T value{};
    if (!fault_.empty()) return value;
    const std::string_view cell = cells_[next_++];
    const auto [stop, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
    bool good = error == std::errc() && stop == cell.data() + cell.size();
    if constexpr (std::is_floating_point_v<T>) good = good && std::isfinite(value);
    if (!good) {
      fault_ = "has '" + std::string(cell.substr(0, 40)) + "' in cell " + std::to_string(next_) +
               "; it must be a number";
    }
    return value;
  }
  Eigen::Vector3d Vector() {
    const double x = Number<double>(), y = Number<double>(), z = Number<double>();
    return {x, y, z};
  }
  std::string Text() { return fault_.empty() ? std::string(cells_[next_++]) : ""; }
  const std::string& Fault() const { return fault_; }

 private:
  std::vector<std::string_view> cells_;
  std::size_t next_ = 0;
  std::string fault_;
};

/// The row, or what is wrong with the line.
base::Result<TruthRow> ParseTruthLine(std::string_view line, base::TimeNs earliest_ns) {
  TruthCells cells(line);
  TruthRow row;
  row.mid_exposure_ns = cells.Number<base::TimeNs>();
  row.trigger = cells.Number<std::uint64_t>();
  row.target = cells.Text();
  row.epicenter_m = cells.Vector();
  row.direction = cells.Vector();
  for (Eigen::Vector3d& led_m : row.leds_m) led_m = cells.Vector();
  row.visible = cells.Number<int>();
  std::string fault = cells.Fault();
  if (fault.empty() && row.target.empty()) fault = "names no target";
  if (fault.empty() && (row.visible < 0 || row.visible > base::kLedCount))
    fault = "has " + std::to_string(row.visible) + " visible LEDs; it must be 0 to 4";
  if (fault.empty() && std::abs(row.direction.norm() - 1) > 1e-4)
    fault = "has a direction of length " + std::to_string(row.direction.norm()) + "; it must be 1";
  if (fault.empty() && row.mid_exposure_ns < earliest_ns)
    fault = "has the time " + std::to_string(row.mid_exposure_ns) + ", before that of the line above";
  if (!fault.empty()) return Error{ErrorCode::kMalformed, "", fault};
  return row;
}

}  // namespace

std::vector<TruthRow> TruthRows(const World& world, std::uint64_t trigger) {
  std::vector<TruthRow> rows;
  for (const TargetTruth& truth : world.TruthAt(trigger)) {
    rows.push_back({world.MidExposureNs(trigger), trigger, world.GetScene().targets[truth.target].target.name,
                    truth.epicenter_m, truth.direction, truth.leds_m, truth.Visible()});
  }
  return rows;
}

std::string TruthHeader() {
  std::string header = "timestamp_ns,trigger,target,x_m,y_m,z_m,dx,dy,dz";
  for (int i = 1; i <= base::kLedCount; ++i) {
    for (const char axis : {'x', 'y', 'z'}) {
      header += ",led";
      header += std::to_string(i);
      header += '_';
      header += axis;
      header += "_m";
    }
  }
  return header + ",visible\n";
}

std::string FormatTruth(const std::vector<TruthRow>& rows) {
  std::string text;
  std::array<char, 32> cell{};
  const auto add = [&text, &cell](const Eigen::Vector3d& v) {
    for (int i = 0; i < 3; ++i) {
      std::snprintf(cell.data(), cell.size(), ",%.7f", v[i]);
      text += cell.data();
    }
  };
  for (const TruthRow& row : rows) {
    text += std::to_string(row.mid_exposure_ns) + "," + std::to_string(row.trigger) + "," + row.target;
    add(row.epicenter_m);
    add(row.direction);
    for (const Eigen::Vector3d& led_m : row.leds_m) add(led_m);
    text += "," + std::to_string(row.visible) + "\n";
  }
  return text;
}

base::Result<std::vector<TruthRow>> ReadTruth(const std::string& path) {
  std::ifstream file(path);
  if (!file) return Error{ErrorCode::kNotFound, path, "cannot be read"};
  std::vector<TruthRow> rows;
  std::string line;
  const auto next_line = [&file, &line] {
    if (!std::getline(file, line)) return false;
    if (!line.empty() && line.back() == '\r') line.pop_back();
    return true;
  };
  if (!next_line() || line + "\n" != TruthHeader()) {
    return Error{ErrorCode::kMalformed, path + ":1",
                 "is not the header of a truth file: " + TruthHeader().substr(0, 60) + "..."};
  }
  base::TimeNs earliest_ns = 0;
  for (int number = 2; next_line(); ++number) {
    const std::string where = path + ":" + std::to_string(number);
    if (line.empty()) continue;
    auto row = ParseTruthLine(line, earliest_ns);
    if (!row) return Error{ErrorCode::kMalformed, where, row.error().detail};
    earliest_ns = row->mid_exposure_ns;
    rows.push_back(std::move(*row));
  }
  return rows;
}

}  // namespace adit::sim
