#include "host/bus_reader.h"

#include <charconv>

namespace adit::host {
namespace {

/// The whole of `text` as a number.
template <class T>
bool ReadWhole(std::string_view text, T& value, int base = 10) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
  return !text.empty() && error == std::errc() && end == text.data() + text.size();
}

publish::ReceiverRules DemonstrationRules() {
  publish::ReceiverRules rules;
  rules.accept_simulated = true;
  return rules;
}

}  // namespace

std::optional<LoggedFrame> ParseCandump(const std::string& line) {
  const std::size_t close = line.find(") "), hash = line.find('#');
  if (line.empty() || line[0] != '(' || close == std::string::npos || hash == std::string::npos ||
      hash < close)
    return {};
  const std::string_view view(line);
  const std::string_view time = view.substr(1, close - 1);
  const std::size_t point = time.find('.'), space = line.rfind(' ', hash);
  std::int64_t seconds = 0, microseconds = 0;
  LoggedFrame logged;
  const std::string_view id = view.substr(space + 1, hash - space - 1), data = view.substr(hash + 1);
  if (point == std::string::npos || time.size() - point != 7 || !ReadWhole(time.substr(0, point), seconds) ||
      !ReadWhole(time.substr(point + 1), microseconds) || !ReadWhole(id, logged.frame.id, 16) ||
      data.size() > 16 || data.size() % 2 != 0) {
    return {};
  }
  logged.time_ns = seconds * base::kNsPerS + microseconds * base::kNsPerUs;
  logged.frame.extended = id.size() == 8;
  logged.frame.length = static_cast<std::uint8_t>(data.size() / 2);
  for (std::size_t i = 0; i < data.size() / 2; ++i) {
    if (!ReadWhole(data.substr(2 * i, 2), logged.frame.data[i], 16)) return {};
  }
  return logged;
}

BusReader::BusReader(std::string path, std::uint8_t node)
    : path_(std::move(path)), node_(node), receiver_(node, DemonstrationRules()) {}

std::size_t BusReader::Follow() {
  if (!file_.is_open()) file_.open(path_);
  std::size_t frames = 0;
  std::string line;
  while (file_.is_open() && std::getline(file_, line)) {
    partial_ += line;
    if (file_.eof()) break;  // no line end yet: the rest comes later
    const auto logged = ParseCandump(partial_);
    partial_.clear();
    if (!logged) {
      ++bad_lines_;
      continue;
    }
    if (!publish::SlotOf(logged->frame, node_)) continue;
    receiver_.Accept(logged->frame, logged->time_ns);
    last_frame_ns_ = logged->time_ns;
    ++frames;
  }
  file_.clear();
  return frames;
}

}  // namespace adit::host
