#include "host/csv_table.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>

#include "firmware/base/require.h"

namespace adit::host {
namespace {

using base::Error;
using base::ErrorCode;

std::vector<std::string> Cells(std::string_view line) {
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  std::vector<std::string> cells;
  for (;;) {
    const std::size_t comma = line.find(',');
    cells.emplace_back(line.substr(0, comma));
    if (comma == std::string_view::npos) return cells;
    line.remove_prefix(comma + 1);
  }
}

/// All of `text` as a T.
template <class T>
std::optional<T> Parsed(std::string_view text) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size() ? std::optional<T>(value) : std::nullopt;
}

}  // namespace

base::Result<CsvTable> CsvTable::Open(const std::string& path, const std::vector<std::string>& required) {
  std::ifstream file(path);
  std::string line;
  if (!file || !std::getline(file, line)) {
    return Error{ErrorCode::kNotFound, path, "cannot be read: no such file, no permission, or empty"};
  }
  CsvTable table;
  table.path_ = path;
  if (!line.empty() && line.front() == '#') line.erase(0, 1);  // EuRoC marks its header so
  table.header_ = Cells(line);
  for (const std::string& column : required) {
    if (std::find(table.header_.begin(), table.header_.end(), column) == table.header_.end())
      return Error{ErrorCode::kMalformed, path + ":1", "has no column '" + column + "'"};
  }
  for (std::size_t number = 2; std::getline(file, line); ++number) {
    if (line.empty() || line == "\r") continue;
    Row row{number, Cells(line)};
    if (row.cells.size() != table.header_.size()) {
      return Error{ErrorCode::kMalformed, path + ":" + std::to_string(number),
                   "has " + std::to_string(row.cells.size()) + " cells; the header has " +
                       std::to_string(table.header_.size())};
    }
    table.rows_.push_back(std::move(row));
  }
  return table;
}

std::string_view CsvTable::Text(std::size_t row, std::string_view column) const {
  const auto found = std::find(header_.begin(), header_.end(), column);
  ADIT_REQUIRE(found != header_.end());
  return rows_[row].cells[static_cast<std::size_t>(found - header_.begin())];
}

base::Result<std::optional<double>> CsvTable::Number(std::size_t row, std::string_view column) const {
  const std::string_view text = Text(row, column);
  if (text.empty()) return std::optional<double>{};
  const auto number = Parsed<double>(text);
  if (!number || !std::isfinite(*number)) {
    return Error{ErrorCode::kMalformed, Where(row, column),
                 "is '" + std::string(text) + "'; it must be a number or empty"};
  }
  return number;
}

base::Result<base::TimeNs> CsvTable::Time(std::size_t row, std::string_view column) const {
  const std::string_view text = Text(row, column);
  const auto time_ns = Parsed<base::TimeNs>(text);
  if (!time_ns) {
    return Error{ErrorCode::kMalformed, Where(row, column),
                 "is '" + std::string(text) + "'; it must be whole nanoseconds"};
  }
  return *time_ns;
}

std::string CsvTable::Where(std::size_t row, std::string_view column) const {
  return path_ + ":" + std::to_string(rows_[row].line) + ": " + std::string(column);
}

}  // namespace adit::host
