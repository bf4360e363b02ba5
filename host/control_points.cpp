#include "host/control_points.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "host/gsi.h"
#include "host/provenance.h"

namespace adit::host {
namespace {

using base::Error;
using base::ErrorCode;

constexpr std::size_t kLargestFileBytes = 16 << 20;
constexpr double kLargestCoordinateM = 1e8;
constexpr double kLargestSigmaM = 1;
constexpr std::array<std::string_view, 5> kControlColumns{"name", "easting_m", "northing_m", "height_m",
                                                          "sigma_m"};
constexpr std::size_t kName = 0, kFirstCoordinate = 1, kSigma = 4;

std::string_view Trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") + 1 - first);
}

std::vector<std::string_view> Split(std::string_view line) {
  std::vector<std::string_view> fields;
  for (;;) {
    const std::size_t comma = line.find(',');
    fields.push_back(Trimmed(line.substr(0, comma)));
    if (comma == std::string_view::npos) return fields;
    line.remove_prefix(comma + 1);
  }
}

/// Reads the rows below one header.
class CsvReader {
 public:
  /// Where each of kControlColumns stands in the rows. Declines when the header is another one.
  base::Result<void> ReadHeader(std::string_view line, const std::string& where) {
    for (const std::string_view field : Split(line)) {
      const auto* const column = std::find(kControlColumns.begin(), kControlColumns.end(), field);
      if (column == kControlColumns.end() || std::find(order_.begin(), order_.end(), field) != order_.end())
        return RefuseHeader(where, "column '" + std::string(field) + "' is unknown or stands there twice");
      order_.emplace_back(field);
    }
    for (const std::string_view column : kControlColumns) {
      if (column != kControlColumns[kSigma] &&
          std::find(order_.begin(), order_.end(), column) == order_.end())
        return RefuseHeader(where, "column " + std::string(column) + " is missing");
    }
    return {};
  }

  base::Result<ControlPoint> ReadRow(std::string_view line, const std::string& where) const {
    const std::vector<std::string_view> fields = Split(line);
    if (fields.size() != order_.size()) {
      return Error{ErrorCode::kMalformed, where,
                   "has " + std::to_string(fields.size()) + " fields; the header has " +
                       std::to_string(order_.size())};
    }
    ControlPoint point;
    for (std::size_t i = 0; i < 3; ++i) point.enh[i].word = kControlColumns[kFirstCoordinate + i];
    for (std::size_t i = 0; i < fields.size(); ++i) {
      if (auto read = Take(order_[i], fields[i], where, point); !read) return read.error();
    }
    if (point.name.empty()) return Error{ErrorCode::kMalformed, where, "name is empty"};
    return point;
  }

 private:
  static Error RefuseHeader(const std::string& where, const std::string& detail) {
    return {ErrorCode::kMalformed, where,
            detail + "; the first line must be name,easting_m,northing_m,height_m[,sigma_m]"};
  }

  static base::Result<void> Take(const std::string& column, std::string_view field, const std::string& where,
                                 ControlPoint& point) {
    if (column == kControlColumns[kName]) {
      point.name = field;
      return {};
    }
    if (field.empty()) return {};
    const bool is_sigma = column == kControlColumns[kSigma];
    double value = 0;
    const auto end = std::from_chars(field.data(), field.data() + field.size(), value);
    const bool is_number = end.ec == std::errc() && end.ptr == field.data() + field.size();
    const bool is_allowed =
        is_sigma ? value > 0 && value <= kLargestSigmaM : std::abs(value) <= kLargestCoordinateM;
    if (!is_number || !is_allowed) {
      return Error{ErrorCode::kMalformed, where,
                   column + " is '" + std::string(field) + "'; it must be a number " +
                       (is_sigma ? "above 0, at most 1" : "from -1e8 to 1e8")};
    }
    if (is_sigma) {
      point.sigma_m = value;
    } else {
      const auto* const place = std::find(kControlColumns.begin(), kControlColumns.end(), column);
      point.enh[static_cast<std::size_t>(place - kControlColumns.begin()) - kFirstCoordinate].value_m = value;
    }
    return {};
  }

  std::vector<std::string> order_;  ///< the columns of a row
};

/// Refuses what would garble a message or a report: control characters, and line ends of CR alone.
base::Result<void> CheckText(std::string_view text, const std::string& path) {
  constexpr char kEndOfFile = '\x1a';  // old transfer programs end files with it
  std::size_t line = 1;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    line += c == '\n' ? 1 : 0;
    const bool ends_line = c == '\n' || (c == '\r' && i + 1 < text.size() && text[i + 1] == '\n');
    if (ends_line || c == '\t' || c == kEndOfFile || (static_cast<unsigned char>(c) >= 0x20 && c != 0x7F))
      continue;
    return Error{ErrorCode::kMalformed, path + ":" + std::to_string(line),
                 "is no text: it holds the control character " + std::to_string(static_cast<int>(c))};
  }
  return {};
}

base::Result<std::string> ReadBytes(const std::string& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored))
    return Error{ErrorCode::kNotFound, path, "is a folder; give the path of a .csv or .gsi file"};
  std::ifstream file(path, std::ios::binary);
  if (!file) return Error{ErrorCode::kNotFound, path, std::string("cannot be read: ") + std::strerror(errno)};
  std::string text(kLargestFileBytes + 1, '\0');
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(file.gcount()));
  if (text.size() > kLargestFileBytes)
    return Error{ErrorCode::kMalformed, path, "is larger than 16 MiB; control points have some KB"};
  if (auto checked = CheckText(text, path); !checked) return checked.error();
  return text;
}

std::string Ending(const std::string& path) {
  std::string ending = std::filesystem::path(path).extension().string();
  for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return ending;
}

}  // namespace

base::Result<Eigen::Vector3d> ControlFile::PositionOf(const ControlPoint& point) const {
  Eigen::Vector3d position_m;
  for (std::size_t i = 0; i < 3; ++i) {
    const Coordinate& coordinate = point.enh[i];
    if (!coordinate.value_m) {
      return Error{ErrorCode::kMalformed, path + ":" + std::to_string(point.line),
                   "point " + point.name + ": word " + coordinate.word +
                       " has no value; a control point needs easting, northing and height"};
    }
    position_m[static_cast<Eigen::Index>(i)] = *coordinate.value_m;
  }
  return position_m;
}

base::Result<const ControlPoint*> ControlFile::Find(const std::string& name) const {
  const ControlPoint* found = nullptr;
  for (const ControlPoint& point : points) {
    if (point.name != name) continue;
    if (found != nullptr) {
      return Error{ErrorCode::kMalformed, path + ":" + std::to_string(point.line),
                   "point " + name + " stands in line " + std::to_string(found->line) +
                       " too; keep the one that holds"};
    }
    found = &point;
  }
  return found;
}

base::Result<std::vector<ControlPoint>> ParseControlCsv(std::string_view text, const std::string& path) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";  // spreadsheets write it
  if (text.substr(0, kByteOrderMark.size()) == kByteOrderMark) text.remove_prefix(kByteOrderMark.size());
  std::vector<ControlPoint> points;
  CsvReader reader;
  bool has_header = false;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::size_t end = text.find('\n');
    const std::string_view line = Trimmed(text.substr(0, end));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    if (line.empty()) continue;
    const std::string where = path + ":" + std::to_string(number);
    if (!has_header) {
      if (auto header = reader.ReadHeader(line, where); !header) return header.error();
      has_header = true;
      continue;
    }
    auto point = reader.ReadRow(line, where);
    if (!point) return point.error();
    point->line = number;
    points.push_back(std::move(*point));
  }
  return points;
}

base::Result<ControlFile> LoadControlPoints(const std::string& path,
                                            const std::optional<Eigen::Vector3d>& gsi8_offset_m) {
  const std::string ending = Ending(path);
  if (ending != ".csv" && ending != ".gsi")
    return Error{ErrorCode::kUsage, path, "ends with '" + ending + "'; control points are .csv or .gsi"};
  const auto bytes = ReadBytes(path);
  if (!bytes) return bytes.error();
  auto points = ending == ".csv" ? ParseControlCsv(*bytes, path) : ParseGsi(*bytes, path, gsi8_offset_m);
  if (!points) return points.error();
  if (points->empty()) return Error{ErrorCode::kMalformed, path, "holds no point with coordinates"};
  const auto has_offset = [](const ControlPoint& point) { return point.has_offset; };
  if (gsi8_offset_m && std::none_of(points->begin(), points->end(), has_offset))
    return Error{ErrorCode::kUsage, "--gsi8-offset-m", "is given, but " + path + " holds no GSI-8"};
  return ControlFile{path, Crc32(*bytes), std::move(*points)};
}

}  // namespace adit::host
