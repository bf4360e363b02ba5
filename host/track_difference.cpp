#include "host/track_difference.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <map>
#include <set>
#include <sstream>
#include <utility>

namespace adit::host {
namespace {

using pipeline::TrackRow;
using Rows = std::map<std::pair<base::TimeNs, std::string>, const TrackRow*>;

Rows ByTimeAndTarget(const std::vector<TrackRow>& track) {
  Rows rows;
  for (const TrackRow& row : track) rows.emplace(std::pair(row.timestamp_ns, row.target), &row);
  return rows;
}

bool Found(const TrackRow& row) { return row.status != stereo::FixStatus::kLost; }

/// Whether `there` stands nearer to another target of `rows` than to its own place `here`.
bool IsElsewhere(const TrackRow& here, const TrackRow& there, const Rows& rows) {
  const double own_m = (there.position_m - here.position_m).norm();
  const auto first = rows.lower_bound({here.timestamp_ns, ""});
  for (auto at = first; at != rows.end() && at->first.first == here.timestamp_ns; ++at) {
    const TrackRow& other = *at->second;
    if (&other != &here && Found(other) && (there.position_m - other.position_m).norm() < own_m) return true;
  }
  return false;
}

void Add(const TrackRow& a, const TrackRow& b, const Rows& rows_a, TargetDifference& out) {
  out.found += !Found(a) && Found(b) ? 1 : 0;
  out.lost += Found(a) && !Found(b) ? 1 : 0;
  if (!Found(a) || !Found(b)) return;
  ++out.both;
  out.status_changes += a.status != b.status || a.recovered_mask != b.recovered_mask ? 1 : 0;
  out.swapped += IsElsewhere(a, b, rows_a) ? 1 : 0;
  const double apart_m = (a.position_m - b.position_m).norm();
  out.max_m = std::max(out.max_m, apart_m);
  out.rms_m += apart_m * apart_m;  // a sum until all rows are in
}

TargetDifference CompareTarget(const std::string& target, const Rows& a, const Rows& b) {
  TargetDifference out;
  out.target = target;
  for (const auto& [key, row] : a) {
    if (key.second != target) continue;
    const auto other = b.find(key);
    if (other == b.end())
      ++out.unpaired;
    else
      Add(*row, *other->second, a, out);
  }
  for (const auto& [key, row] : b) out.unpaired += key.second == target && !a.contains(key) ? 1 : 0;
  if (out.both > 0) out.rms_m = std::sqrt(out.rms_m / static_cast<double>(out.both));
  return out;
}

}  // namespace

bool TrackDifference::Same(double tolerance_m) const {
  return std::all_of(targets.begin(), targets.end(), [tolerance_m](const TargetDifference& t) {
    return t.found + t.lost + t.swapped + t.status_changes + t.unpaired == 0 && t.max_m <= tolerance_m;
  });
}

TrackDifference CompareTracks(const std::vector<TrackRow>& a, const std::vector<TrackRow>& b) {
  const Rows rows_a = ByTimeAndTarget(a), rows_b = ByTimeAndTarget(b);
  std::set<std::string> names;
  for (const auto* rows : {&rows_a, &rows_b}) {
    for (const auto& [key, row] : *rows) names.insert(key.second);
  }
  TrackDifference difference;
  for (const std::string& name : names) difference.targets.push_back(CompareTarget(name, rows_a, rows_b));
  return difference;
}

std::string FormatDifferenceTable(const TrackDifference& difference) {
  std::ostringstream text;
  text << "target               both    found     lost  swapped   status unpaired       rms_mm       max_mm\n"
       << std::fixed << std::setprecision(3);
  for (const TargetDifference& t : difference.targets) {
    text << std::left << std::setw(16) << t.target << std::right;
    for (const std::size_t count : {t.both, t.found, t.lost, t.swapped, t.status_changes, t.unpaired})
      text << std::setw(9) << count;
    text << std::setw(13) << t.rms_m * 1e3 << std::setw(13) << t.max_m * 1e3 << "\n";
  }
  return text.str();
}

std::string FormatDifferenceJson(const TrackDifference& difference, double tolerance_m) {
  std::ostringstream text;
  text << std::setprecision(9) << "{\n  \"tolerance_m\": " << tolerance_m
       << ",\n  \"same\": " << (difference.Same(tolerance_m) ? "true" : "false") << ",\n  \"targets\": [";
  const char* separator = "\n";
  for (const TargetDifference& t : difference.targets) {
    // A target's name holds no quotes or line ends: the track is refused otherwise.
    text << separator << "    {\"target\": \"" << t.target << "\", \"both\": " << t.both
         << ", \"found\": " << t.found << ", \"lost\": " << t.lost << ", \"swapped\": " << t.swapped
         << ", \"status_changes\": " << t.status_changes << ", \"unpaired\": " << t.unpaired
         << ", \"rms_m\": " << t.rms_m << ", \"max_m\": " << t.max_m << "}";
    separator = ",\n";
  }
  text << "\n  ]\n}\n";
  return text.str();
}

}  // namespace adit::host
