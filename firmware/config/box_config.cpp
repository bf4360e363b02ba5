#include "firmware/config/box_config.h"

#include <boost/crc.hpp>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <iterator>
#include <optional>
#include <sstream>

#include "firmware/config/box_keys.h"

namespace adit::config {
namespace {

using base::Range;
using base::YamlReader;

/// Fills a configuration from YAML. A map that is absent leaves its defaults.
class KeyReader {
 public:
  explicit KeyReader(const YamlReader& root) { places_.push_back(root); }

  void Enter(const char* name) {
    std::optional<YamlReader> child;
    if (At(name)) child = At(name)->Child(name);
    places_.push_back(child);
  }
  void Leave() { places_.pop_back(); }
  void Text(const char* key, std::string& value, KeyNote) {
    if (At(key)) value = At(key)->Text(key);
  }
  void Required(const char* key, std::string& value, KeyNote) { value = places_.front()->Text(key); }
  void Texts(const char* key, std::vector<std::string>& value, KeyNote) {
    if (At(key)) value = At(key)->TextsOr(key, value);
  }
  void RequiredTexts(const char* key, std::vector<std::string>& value, KeyNote) {
    value = places_.front()->TextsOr(key, {});
    if (value.empty()) places_.front()->Refuse(key, "is missing or empty; it must be a list of files");
  }
  void Choice(const char* key, std::string& value, const std::vector<std::string>& allowed, KeyNote) {
    if (At(key)) value = At(key)->Choice(key, allowed);
  }
  void Flag(const char* key, bool& value, KeyNote) {
    if (At(key)) value = At(key)->BoolOr(key, value);
  }
  void Whole(const char* key, long& value, Range range, KeyNote) {
    if (At(key)) value = At(key)->Integer(key, range);
  }
  void Number(const char* key, double& value, Range range, KeyNote) {
    if (At(key)) value = At(key)->Number(key, range);
  }
  void Numbers(const char* key, std::vector<double>& value, std::size_t count, Range range, KeyNote) {
    if (At(key)) value = At(key)->Numbers(key, count, range);
  }

 private:
  /// The map that holds `key`, if there is one; `key` is known there from now on.
  YamlReader* At(const char* key) {
    if (!places_.back()) return nullptr;
    places_.back()->Ignore(key);
    return places_.back()->Has(key) ? &*places_.back() : nullptr;
  }
  std::vector<std::optional<YamlReader>> places_;
};

std::string Written(const std::string& value) { return base::Quoted(value); }

std::string Written(double value) {
  std::ostringstream text;
  text << std::setprecision(12) << value;  // millimetres of a site coordinate, and 0.1 stays 0.1
  return text.str();
}

template <class T>
std::string Bracketed(const std::vector<T>& values) {
  std::string text = "[";
  for (std::size_t i = 0; i < values.size(); ++i) text += (i == 0 ? "" : ", ") + Written(values[i]);
  return text + "]";
}

/// Writes a configuration as YAML, with or without the notes on every key.
class KeyWriter {
 public:
  explicit KeyWriter(bool with_notes) : with_notes_(with_notes) {}

  void Enter(const char* name) { Indent() << name << ":\n", depth_ += 1; }
  void Leave() { depth_ -= 1; }
  void Text(const char* key, const std::string& value, KeyNote note) {
    if (!with_notes_ && value.empty()) return;  // an absent text, not an empty one
    Line(key, base::Quoted(value), "text", note);
  }
  void Required(const char* key, const std::string& value, KeyNote note) {
    Line(key, base::Quoted(value), "file, required", note);
  }
  void Texts(const char* key, const std::vector<std::string>& value, KeyNote note) {
    Line(key, Bracketed(value), "list of texts", note);
  }
  void RequiredTexts(const char* key, const std::vector<std::string>& value, KeyNote note) {
    Line(key, Bracketed(value), "list of files, required", note);
  }
  void Choice(const char* key, const std::string& value, const std::vector<std::string>& allowed,
              KeyNote note) {
    std::string words;
    for (const std::string& word : allowed) words += (words.empty() ? "" : " | ") + word;
    Line(key, value, words, note);
  }
  void Flag(const char* key, bool value, KeyNote note) {
    Line(key, value ? "true" : "false", "true | false", note);
  }
  void Whole(const char* key, long value, Range range, KeyNote note) {
    Line(key, std::to_string(value), "whole number, " + Allowed(range), note);
  }
  void Number(const char* key, double value, Range range, KeyNote note) {
    Line(key, Written(value), Allowed(range), note);
  }
  void Numbers(const char* key, const std::vector<double>& value, std::size_t count, Range range,
               KeyNote note) {
    Line(key, Bracketed(value),
         (count == 0 ? "list" : "list of " + std::to_string(count)) + ", each " + Allowed(range), note);
  }
  std::string Done() const { return text_.str(); }

 private:
  static std::string Allowed(Range range) {
    std::ostringstream text;
    text << range.min << " to " << range.max;
    return text.str();
  }
  std::ostream& Indent() { return text_ << std::string(static_cast<std::size_t>(2 * depth_), ' '); }
  void Line(const char* key, const std::string& value, const std::string& allowed, KeyNote note) {
    if (with_notes_) {
      const std::string unit = *note.unit != '\0' ? std::string(" ") + note.unit : "";
      Indent() << "# " << note.meaning << " (" << allowed << unit << ")\n";
    }
    Indent() << key << ": " << value << "\n";
  }
  bool with_notes_;
  int depth_ = 0;
  std::ostringstream text_;
};

/// What no single key can say.
void CheckTogether(const BoxConfig& config, YamlReader& in) {
  const CamerasConfig& cameras = config.cameras;
  if (cameras.driver == "aravis" && (cameras.left.device.empty() || cameras.right.device.empty())) {
    in.Refuse("cameras", "needs left.device and right.device with the driver aravis");
  }
  if (cameras.driver == "aravis" && !cameras.left.device.empty() &&
      cameras.left.device == cameras.right.device) {
    in.Refuse("cameras", "names the device '" + cameras.left.device + "' on both sides");
  }
  if (cameras.driver == "recording" && cameras.recording.empty()) {
    in.Refuse("cameras", "needs the key recording with the driver recording");
  }
  if (cameras.bits != 8 && cameras.bits != 10 && cameras.bits != 12) {
    in.Refuse("cameras.bits", "is " + std::to_string(cameras.bits) + "; it must be 8, 10 or 12");
  }
  if (cameras.exposure_us > 1e6 / cameras.rate_hz) {
    in.Refuse("cameras.exposure_us", "is longer than the time from trigger to trigger");
  }
  if (config.publish.can.driver == "candump" && config.publish.can.log.empty()) {
    in.Refuse("publish.can", "needs the key log with the driver candump");
  }
  for (const double origin_m : config.publish.site_origin_m) {
    if (origin_m != static_cast<double>(static_cast<long>(origin_m))) {
      in.Refuse("publish.site_origin_m", "must be whole metres");
    }
  }
  const std::size_t lights = config.watch.lights_m.size();
  if (lights % 3 != 0 || lights == 3 || lights == 6) {
    in.Refuse("watch.lights_m", "holds " + std::to_string(lights) +
                                    " numbers; it needs three for each light, and three lights or none");
  }
}

}  // namespace

std::string BoxConfig::Resolve(const std::string& path) const {
  const std::filesystem::path given(path);
  return given.is_absolute() || folder.empty() ? path : (std::filesystem::path(folder) / given).string();
}

base::Result<BoxConfig> LoadBoxConfig(const std::string& path) {
  auto in = YamlReader::OpenFile(path);
  if (!in) return in.error();
  BoxConfig config;
  KeyReader reader(*in);
  DescribeBox(config, reader);
  if (in->Ok()) CheckTogether(config, *in);
  if (auto done = in->Finish(); !done) return done.error();
  config.folder = std::filesystem::path(path).parent_path().string();
  std::ifstream file(path, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  boost::crc_32_type crc;
  crc.process_bytes(bytes.data(), bytes.size());
  config.crc32 = crc.checksum();
  return config;
}

std::string FormatBoxSchema() {
  BoxConfig defaults;
  KeyWriter writer(true);
  DescribeBox(defaults, writer);
  return writer.Done();
}

std::string FormatBoxConfig(const BoxConfig& config) {
  BoxConfig copy = config;
  KeyWriter writer(false);
  DescribeBox(copy, writer);
  return writer.Done();
}

}  // namespace adit::config
