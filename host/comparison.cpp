#include "host/comparison.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

namespace adit::host {
namespace {

using base::Error;
using base::ErrorCode;
using base::TimeNs;
using Eigen::Vector3d;
using pipeline::TrackRow;
using sim::TruthRow;

constexpr TimeNs kSameExposureNs = base::kNsPerMs;  // frames follow each other by 4 ms or more
constexpr std::array<double, 7> kEdgesM{0, 20, 30, 50, 80, 110, 1000};

double BarM(const TruthRow& truth) { return (truth.leds_m.back() - truth.leds_m.front()).norm(); }

/// Sums over the pairs of one target in one range.
struct Sums {
  Figures figures;
  double squares_m2 = 0, nees = 0, bar_abs_m = 0, bar_squares_m2 = 0, true_bar_m = 0;

  void Add(const TrackRow& found, const TruthRow& truth) {
    const Vector3d error_m = found.position_m - truth.epicenter_m;
    ++figures.tracked;
    figures.recovered += found.status == stereo::FixStatus::kRecovered ? 1 : 0;
    figures.max_m = std::max(figures.max_m, error_m.norm());
    figures.bias_m += error_m;
    figures.flips += found.direction.dot(truth.direction) < 0 ? 1 : 0;
    squares_m2 += error_m.squaredNorm();
    nees += error_m.cwiseQuotient(found.sigma_m).squaredNorm();
    bar_abs_m += std::abs(found.bar_m - BarM(truth));
    bar_squares_m2 += found.bar_m * found.bar_m;
    true_bar_m += BarM(truth);
  }

  Figures Finish() const {
    Figures out = figures;
    const auto count = static_cast<double>(out.tracked);
    if (out.tracked == 0) out.max_m = std::numeric_limits<double>::quiet_NaN();  // so are all means: 0 / 0
    out.rms_m = std::sqrt(squares_m2 / count);
    out.bias_m /= count;
    out.nees = nees / count;
    out.bar_mae_m = bar_abs_m / count;
    out.bar_xrms_m = std::abs(true_bar_m / count - std::sqrt(bar_squares_m2 / count)) / 2;
    return out;
  }
};

/// The ranges of one target, the first one over all distances.
class TargetSums {
 public:
  explicit TargetSums(const std::string& target) {
    sums_[0].figures.target = target;
    sums_[0].figures.to_m = kEdgesM.back();
    for (std::size_t i = 1; i < sums_.size(); ++i) {
      sums_[i].figures.target = target;
      sums_[i].figures.from_m = kEdgesM[i - 1];
      sums_[i].figures.to_m = kEdgesM[i];
    }
  }

  /// One truth row, with what was found for it (or null).
  void Add(const TruthRow& truth, const TrackRow* found, int visible_min) {
    const double distance_m = truth.epicenter_m.norm();
    for (Sums& sums : sums_) {
      if (distance_m < sums.figures.from_m || distance_m >= sums.figures.to_m) continue;
      if (truth.visible < visible_min) {
        sums.figures.hidden += found != nullptr ? 1 : 0;
        continue;
      }
      ++sums.figures.visible;
      if (found != nullptr) sums.Add(*found, truth);
    }
  }

  void Finish(std::vector<Figures>& out) const {
    for (const Sums& sums : sums_) {
      if (&sums == &sums_[0] || sums.figures.visible > 0) out.push_back(sums.Finish());
    }
  }

 private:
  std::array<Sums, kEdgesM.size()> sums_;
};

}  // namespace

base::Result<Comparison> Compare(const std::vector<TrackRow>& track, const std::vector<TruthRow>& truth,
                                 int visible_min) {
  std::map<std::pair<std::string, TimeNs>, const TrackRow*> found;
  for (const TrackRow& row : track) {
    const bool measured =
        row.status == stereo::FixStatus::kTracked || row.status == stereo::FixStatus::kRecovered;
    if (measured) found[{row.target, row.timestamp_ns}] = &row;
  }
  Comparison out;
  std::map<std::string, TargetSums> targets;
  std::size_t visible = 0, used = 0;
  for (const TruthRow& point : truth) {
    auto& sums = targets.try_emplace(point.target, point.target).first->second;
    const auto match = found.lower_bound({point.target, point.mid_exposure_ns - kSameExposureNs});
    const bool matches = match != found.end() && match->first.first == point.target &&
                         match->first.second <= point.mid_exposure_ns + kSameExposureNs;
    sums.Add(point, matches ? match->second : nullptr, visible_min);
    visible += point.visible >= visible_min ? 1 : 0;
    if (matches && point.visible >= visible_min) {
      const TrackRow& row = *match->second;
      out.rows.push_back({point.target, point.epicenter_m, row.position_m - point.epicenter_m, row.sigma_m,
                          row.bar_m - BarM(point)});
    }
    used += matches ? 1 : 0;
  }
  // Truth rows of one target are exposures apart, so each match is another row of the track.
  out.false_positions = found.size() - std::min(found.size(), used);
  if (visible == 0 && out.false_positions == 0) {
    return Error{ErrorCode::kFailed, "", "nothing to compare: no target is visible in the truth"};
  }
  for (const auto& [name, sums] : targets) sums.Finish(out.figures);
  return out;
}

}  // namespace adit::host
