#include "host/gsi.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstdint>

namespace adit::host {
namespace {

using base::Error;
using base::ErrorCode;

// A word: index and information (6 characters), sign, data.
constexpr std::size_t kSignAt = 6, kUnitAt = 5, kDataAt = 7;

bool IsDigit(char c) { return c >= '0' && c <= '9'; }

std::string_view WithoutFill(std::string_view text) {
  const std::size_t last = text.find_last_not_of(" \t\r\x1a");  // old transfer programs end files with ^Z
  return last == std::string_view::npos ? std::string_view{} : text.substr(0, last + 1);
}

/// The name in the data of a word 11: without the zeros and blanks that fill it up.
std::string PointName(std::string_view data) {
  const std::size_t first = data.find_first_not_of("0 ");
  return first == std::string_view::npos ? "0" : std::string(WithoutFill(data.substr(first)));
}

/// The unit of a word's last digit in 1/metre; 0 if it is none of those that adit takes.
double DigitsPerMetre(char unit) {
  switch (unit) {
    case '0':
      return 1e3;
    case '6':
      return 1e4;
    case '8':
      return 1e5;
    default:
      return 0;
  }
}

/// Reads one line, word after word.
class BlockReader {
 public:
  BlockReader(std::string_view line, std::string where) : line_(line), where_(std::move(where)) {
    gsi16_ = !line_.empty() && line_.front() == '*';
    if (gsi16_) line_.remove_prefix(1);
  }

  /// The point of this block; none if it has no coordinates.
  base::Result<std::optional<ControlPoint>> Read(const std::optional<Eigen::Vector3d>& gsi8_offset_m) {
    ControlPoint point;
    for (std::size_t i = 0; i < 3; ++i) point.enh[i].word = "8" + std::to_string(i + 1) + " (missing)";
    bool has_coordinates = false;
    while (!line_.empty()) {
      const auto word = NextWord();
      if (!word) return word.error();
      if (word->substr(0, 2) == "11") point.name = PointName(word->substr(kDataAt));
      const int axis = AxisOf(*word);
      if (axis < 0) continue;
      has_coordinates = true;
      if (!gsi16_ && !gsi8_offset_m) return RefuseCutOff(*word);
      if (auto read = ReadCoordinate(*word, point.enh[static_cast<std::size_t>(axis)]); !read)
        return read.error();
      auto& value_m = point.enh[static_cast<std::size_t>(axis)].value_m;
      if (!gsi16_ && value_m) {
        *value_m += (*gsi8_offset_m)[axis];
        point.has_offset = true;
      }
    }
    if (!has_coordinates) return std::optional<ControlPoint>{};
    if (point.name.empty()) return Error{ErrorCode::kMalformed, where_, "has coordinates but no word 11"};
    return std::optional<ControlPoint>{point};
  }

 private:
  /// 0, 1, 2 of easting, northing, height; -1 of any other word.
  static int AxisOf(std::string_view word) {
    return word[0] == '8' && word[1] >= '1' && word[1] <= '3' ? word[1] - '1' : -1;
  }

  Error Refuse(std::string_view word, const std::string& detail) const {
    return {ErrorCode::kMalformed, where_, "word " + std::string(word) + " " + detail};
  }

  Error RefuseCutOff(std::string_view word) const {
    return Refuse(
        word,
        "is GSI-8, whose 8 digits cut the front off national coordinates; export GSI-16, or say with "
        "--gsi8-offset-m E N H what was cut off (0 0 0: nothing)");
  }

  base::Result<std::string_view> NextWord() {
    const std::size_t length = kDataAt + (gsi16_ ? 16 : 8);
    const std::string_view word = line_.substr(0, length);
    const bool whole = word.size() == length && IsDigit(word[0]) && IsDigit(word[1]) &&
                       (word[kSignAt] == '+' || word[kSignAt] == '-') &&
                       (line_.size() == length || line_[length] == ' ');
    if (!whole) {
      return Refuse(WithoutFill(word), std::string("is no word of GSI-") + (gsi16_ ? "16" : "8") +
                                           ": two digits, four characters, a sign, " + (gsi16_ ? "16" : "8") +
                                           " characters, then a blank or the end of the line");
    }
    line_.remove_prefix(std::min(line_.size(), length + 1));
    return word;
  }

  base::Result<void> ReadCoordinate(std::string_view word, Coordinate& coordinate) const {
    if (coordinate.value_m) return Refuse(word, "stands there twice in one block");
    coordinate.word = word;
    const double digits_per_metre = DigitsPerMetre(word[kUnitAt]);
    if (digits_per_metre == 0)
      return Refuse(word, std::string("has the unit ") + word[kUnitAt] +
                              "; it must be 0 (mm), 6 (0.1 mm) or 8 (0.01 mm)");
    const std::string_view data = word.substr(kDataAt);
    const bool is_blank =
        data.find('-') != std::string_view::npos && data.find_first_not_of("0-") == std::string_view::npos;
    if (is_blank) return {};
    std::int64_t digits = 0;
    const auto end = std::from_chars(data.data(), data.data() + data.size(), digits);
    if (!IsDigit(data[0]) || end.ptr != data.data() + data.size() || end.ec != std::errc())
      return Refuse(word, "has no whole number after its sign");
    // Division of whole numbers rounds once: the nearest double to what is written.
    const double metres = static_cast<double>(digits) / digits_per_metre;
    coordinate.value_m = word[kSignAt] == '-' ? -metres : metres;
    return {};
  }

  std::string_view line_;
  std::string where_;
  bool gsi16_ = false;
};

}  // namespace

base::Result<std::vector<ControlPoint>> ParseGsi(std::string_view text, const std::string& path,
                                                 const std::optional<Eigen::Vector3d>& gsi8_offset_m) {
  std::vector<ControlPoint> points;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::size_t end = text.find('\n');
    const std::string_view line = WithoutFill(text.substr(0, end));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    auto point = BlockReader(line, path + ":" + std::to_string(number)).Read(gsi8_offset_m);
    if (!point) return point.error();
    if (!point->has_value()) continue;
    (*point)->line = number;
    points.push_back(std::move(**point));
  }
  return points;
}

}  // namespace adit::host
