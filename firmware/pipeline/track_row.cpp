#include "firmware/pipeline/track_row.h"

#include <charconv>
#include <cmath>
#include <fstream>
#include <sstream>

namespace adit::pipeline {
namespace {

using base::ErrorCode;
using stereo::FixStatus;

constexpr std::string_view kHeader =
    "timestamp_ns,trigger,target,status,x_m,y_m,z_m,sx_m,sy_m,sz_m,dx,dy,dz,"
    "led1_x_m,led1_y_m,led1_z_m,led2_x_m,led2_y_m,led2_z_m,led3_x_m,led3_y_m,led3_z_m,"
    "led4_x_m,led4_y_m,led4_z_m,recovered,bar_m,reprojection_px";
constexpr std::size_t kFields = 28;
constexpr std::size_t kFirstNumber = 4;  // x_m
constexpr std::size_t kRecovered = 25;   // between the LEDs and bar_m
constexpr int kDecimals = 6;             // a micrometre
constexpr double kLargest = 1e12;        // longer than any number a survey writes; keeps the buffer small

constexpr std::array<std::string_view, 4> kStatusNames{"tracked", "recovered", "predicted", "lost"};

using Fields = std::array<std::string_view, kFields>;

void AppendNumber(std::string& line, double value) {
  std::array<char, 32> buffer;
  line += ',';
  if (!(std::abs(value) <= kLargest)) return;  // nothing is better than a number that is none
  // to_chars knows no locale and rounds alike everywhere.
  const auto end =
      std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, std::chars_format::fixed, kDecimals);
  const std::string_view text(buffer.data(), static_cast<std::size_t>(end.ptr - buffer.data()));
  line += text == "-0.000000" ? text.substr(1) : text;
}

void AppendVector(std::string& line, const Eigen::Vector3d& v) {
  for (const double value : {v.x(), v.y(), v.z()}) AppendNumber(line, value);
}

std::string RecoveredLeds(std::uint8_t mask) {
  std::string text;
  for (int i = 0; i < base::kLedCount; ++i) {
    if ((mask >> i & 1) == 0) continue;
    if (!text.empty()) text += '|';
    text += static_cast<char>('1' + i);
  }
  return text;
}

/// Reads the fields of one row; the first thing wrong stays.
class RowReader {
 public:
  RowReader(const Fields& fields, const std::string& where) : fields_(fields), where_(where) {}

  template <class Integer>
  Integer Whole(std::size_t field, const char* name) {
    Integer value{};
    const std::string_view text = fields_[field];
    const auto end = std::from_chars(text.data(), text.data() + text.size(), value);
    if (end.ec != std::errc() || end.ptr != text.data() + text.size() || text.empty())
      Refuse(std::string(name) + " is '" + std::string(text) + "'; it must be a whole number");
    return value;
  }

  double Number(std::size_t field) {
    double value = 0;
    const std::string_view text = fields_[field];
    const auto end = std::from_chars(text.data(), text.data() + text.size(), value);
    if (end.ec != std::errc() || end.ptr != text.data() + text.size() || !(std::abs(value) <= kLargest))
      Refuse("field " + std::to_string(field + 1) + " is '" + std::string(text) + "'; it must be a number");
    return value;
  }

  Eigen::Vector3d Vector(std::size_t field) {
    const double x = Number(field), y = Number(field + 1), z = Number(field + 2);
    return {x, y, z};
  }

  FixStatus Status(std::size_t field) {
    for (std::size_t i = 0; i < kStatusNames.size(); ++i) {
      if (fields_[field] == kStatusNames[i]) return static_cast<FixStatus>(i);
    }
    Refuse("status is '" + std::string(fields_[field]) +
           "'; it must be tracked, recovered, predicted or lost");
    return FixStatus::kLost;
  }

  std::uint8_t Recovered(std::size_t field) {
    unsigned mask = 0;
    const std::string_view text = fields_[field];
    for (std::size_t i = 0; i < text.size(); ++i) {
      const bool is_led = text[i] >= '1' && text[i] < '1' + base::kLedCount;
      if (i % 2 == 0 ? !is_led : text[i] != '|' || i + 1 == text.size()) {
        Refuse("recovered is '" + std::string(text) + "'; it must name LEDs, such as 2|3");
        return 0;
      }
      if (is_led) mask |= 1U << (text[i] - '1');
    }
    return static_cast<std::uint8_t>(mask);
  }

  void CheckEmpty(std::size_t from) {
    for (std::size_t i = from; i < kFields; ++i) {
      if (!fields_[i].empty()) return Refuse("is lost but has numbers; a lost row has none");
    }
  }

  void Refuse(std::string detail) {
    if (!error_) error_ = base::Error{ErrorCode::kMalformed, where_, std::move(detail)};
  }
  const std::optional<base::Error>& GetError() const { return error_; }

 private:
  const Fields& fields_;
  const std::string& where_;
  std::optional<base::Error> error_;
};

/// How many fields the line has; the first kFields of them in `fields`.
std::size_t Split(std::string_view line, Fields& fields) {
  std::size_t count = 0;
  for (;;) {
    const std::size_t comma = line.find(',');
    if (count < kFields) fields[count] = line.substr(0, comma);
    ++count;
    if (comma == std::string_view::npos) return count;
    line.remove_prefix(comma + 1);
  }
}

}  // namespace

TrackRow TrackRowOf(const georef::GeoFix& fix, const std::string& name) {
  TrackRow row;
  row.timestamp_ns = fix.state.mid_exposure_ns;
  row.trigger = fix.state.trigger;
  row.target = name;
  const stereo::TargetPoints& points = fix.state.points;
  row.status = points.status;
  if (row.status == FixStatus::kLost) return row;
  row.position_m = fix.position_s_m;
  row.sigma_m = fix.covariance_s_m2.diagonal().cwiseMax(0).cwiseSqrt();
  row.direction = fix.direction_s;
  row.leds_m = fix.leds_s_m;
  row.recovered_mask = points.recovered_mask;
  row.bar_m = points.bar_m;
  row.reprojection_px = points.reprojection_px;
  return row;
}

std::string_view TrackHeader() { return kHeader; }

std::string FormatTrackRow(const TrackRow& row) {
  std::string line = std::to_string(row.timestamp_ns) + ',' + std::to_string(row.trigger) + ',' + row.target +
                     ',' + std::string(kStatusNames[static_cast<std::size_t>(row.status)]);
  if (row.status == FixStatus::kLost) return line.append(kFields - kFirstNumber, ',');
  AppendVector(line, row.position_m);
  AppendVector(line, row.sigma_m);
  AppendVector(line, row.direction);
  for (const Eigen::Vector3d& led_m : row.leds_m) AppendVector(line, led_m);
  line += ',' + RecoveredLeds(row.recovered_mask);
  AppendNumber(line, row.bar_m);
  AppendNumber(line, row.reprojection_px);
  return line;
}

base::Result<TrackRow> ParseTrackRow(std::string_view line, const std::string& where) {
  Fields fields;
  if (const std::size_t count = Split(line, fields); count != kFields) {
    return base::Error{
        ErrorCode::kMalformed, where,
        "has " + std::to_string(count) + " fields; a track row has " + std::to_string(kFields)};
  }
  RowReader in(fields, where);
  TrackRow row;
  row.timestamp_ns = in.Whole<base::TimeNs>(0, "timestamp_ns");
  row.trigger = in.Whole<std::uint64_t>(1, "trigger");
  row.target = fields[2];
  if (row.target.empty()) in.Refuse("target is empty; it must name a target");
  row.status = in.Status(3);
  if (row.status == FixStatus::kLost) {
    in.CheckEmpty(kFirstNumber);
  } else {
    row.position_m = in.Vector(kFirstNumber);
    row.sigma_m = in.Vector(7);
    row.direction = in.Vector(10);
    for (std::size_t i = 0; i < row.leds_m.size(); ++i) row.leds_m[i] = in.Vector(13 + 3 * i);
    row.recovered_mask = in.Recovered(kRecovered);
    row.bar_m = in.Number(26);
    row.reprojection_px = in.Number(27);
    if ((row.recovered_mask != 0) != (row.status == FixStatus::kRecovered))
      in.Refuse("recovered is '" + std::string(fields[kRecovered]) + "' in a row that is " +
                std::string(fields[3]) + "; a recovered row names its LEDs, and no other does");
  }
  if (in.GetError()) return *in.GetError();
  return row;
}

base::Result<std::vector<TrackRow>> ParseTrack(std::string_view text, const std::string& name) {
  std::vector<TrackRow> rows;
  bool header_seen = false;
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::size_t end = text.find('\n');
    std::string_view line = text.substr(0, end);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    if (line.empty()) continue;
    if (!header_seen) {
      if (line != kHeader)
        return base::Error{ErrorCode::kMalformed, name, "does not start with a track's header line"};
      header_seen = true;
      continue;
    }
    auto row = ParseTrackRow(line, name + ":" + std::to_string(number));
    if (!row) return row.error();
    rows.push_back(std::move(*row));
  }
  if (!header_seen)
    return base::Error{ErrorCode::kMalformed, name, "is empty; a track starts with its header line"};
  return rows;
}

base::Result<std::vector<TrackRow>> LoadTrack(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) return base::Error{ErrorCode::kNotFound, path, "cannot be opened; give a track file"};
  std::ostringstream text;
  text << in.rdbuf();
  if (in.bad() || text.bad()) return base::Error{ErrorCode::kUnavailable, path, "cannot be read"};
  return ParseTrack(text.str(), path);
}

}  // namespace adit::pipeline
