#include "host/target_design.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <limits>
#include <sstream>
#include <utility>

namespace adit::host {
namespace {

constexpr double kMergeSigmas = 4.75;  // of a spot's sigma: nearer, two spots above one threshold are one
constexpr double kCentimetre = 0.01;
constexpr std::size_t kLayoutsMax = 320;
constexpr std::size_t kStarts = 24;
constexpr std::size_t kFittingMax = 99;

/// Gaps in steps.
std::vector<base::Target> LayoutsOf(const DesignOrder& order, double gap_m, double step_m) {
  std::vector<base::Target> layouts;
  const auto whole = static_cast<int>(std::floor(order.length_m / step_m + 1e-9));
  const auto least = static_cast<int>(std::ceil(gap_m / step_m - 1e-9));
  for (int a = least; a + 2 * least <= whole; ++a) {
    // A layout and its mirror image are one bar: the shorter outer gap comes first.
    for (int b = least; whole - a - b >= std::max(a, least); ++b) {
      base::Target target;
      target.leds_m = {0, a * step_m, (a + b) * step_m, order.length_m};
      target.epicenter_m = order.length_m / 2;
      if (DirectionSigmas(target, order.distance_m, order.view) >= NeededSigmas(order.view.noise_px))
        layouts.push_back(target);
    }
  }
  return layouts;
}

/// Separations of all pairs; of each layout from itself, that of its two directions.
class SeparationTable {
 public:
  SeparationTable(const std::vector<base::Target>& layouts, const DesignOrder& order)
      : size_(layouts.size()), sigmas_(size_ * size_, std::numeric_limits<double>::infinity()) {
    for (std::size_t i = 0; i < size_; ++i) {
      for (std::size_t j = i + 1; j < size_; ++j) {
        const double sigmas = SeparationSigmas(layouts[i], layouts[j], order.distance_m, order.view);
        sigmas_[i * size_ + j] = sigmas_[j * size_ + i] = sigmas;
      }
      sigmas_[i * size_ + i] = DirectionSigmas(layouts[i], order.distance_m, order.view);
    }
  }
  std::size_t size() const { return size_; }
  double operator()(std::size_t i, std::size_t j) const { return sigmas_[i * size_ + j]; }
  /// Of `candidate` from all `chosen` but the one at place `but`, and of its directions.
  double Nearest(std::size_t candidate, const std::vector<std::size_t>& chosen, std::size_t but) const {
    double nearest = (*this)(candidate, candidate);
    for (std::size_t i = 0; i < chosen.size(); ++i) {
      if (i != but) nearest = std::min(nearest, chosen[i] == candidate ? 0 : (*this)(candidate, chosen[i]));
    }
    return nearest;
  }

 private:
  std::size_t size_;
  std::vector<double> sigmas_;
};

constexpr std::size_t kNoPlace = std::numeric_limits<std::size_t>::max();

double LeastSeparation(const SeparationTable& table, const std::vector<std::size_t>& chosen) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < chosen.size(); ++i)
    least = std::min(least, table.Nearest(chosen[i], chosen, i));
  return least;
}

/// From `start`, each next one the farthest from all before, while it is at least `least` away.
std::vector<std::size_t> FarthestFirst(const SeparationTable& table, std::size_t start, std::size_t count,
                                       double least) {
  std::vector<std::size_t> chosen{start};
  std::vector<double> nearest(table.size());
  for (std::size_t i = 0; i < table.size(); ++i) nearest[i] = i == start ? 0 : table(i, start);
  while (chosen.size() < count) {
    const auto farthest =
        static_cast<std::size_t>(std::max_element(nearest.begin(), nearest.end()) - nearest.begin());
    if (!(nearest[farthest] >= least) || nearest[farthest] == 0) break;
    chosen.push_back(farthest);
    for (std::size_t i = 0; i < table.size(); ++i)
      nearest[i] = std::min(nearest[i], i == farthest ? 0 : table(i, farthest));
  }
  return chosen;
}

/// From `start`, each next one the nearest that is just far enough: packs more than FarthestFirst does.
std::vector<std::size_t> DensestFrom(const SeparationTable& table, std::size_t start, double least) {
  std::vector<std::size_t> chosen{start};
  std::vector<double> nearest(table.size());
  for (std::size_t i = 0; i < table.size(); ++i) nearest[i] = i == start ? 0 : table(i, start);
  while (chosen.size() < kFittingMax) {
    std::size_t next = kNoPlace;
    for (std::size_t i = 0; i < table.size(); ++i) {
      if (nearest[i] >= least && (next == kNoPlace || nearest[i] < nearest[next])) next = i;
    }
    if (next == kNoPlace) break;
    chosen.push_back(next);
    for (std::size_t i = 0; i < table.size(); ++i)
      nearest[i] = std::min(nearest[i], i == next ? 0 : table(i, next));
  }
  return chosen;
}

/// Exchanges one of the nearest two for something farther, while there is such.
void Spread(const SeparationTable& table, std::vector<std::size_t>& chosen) {
  for (bool is_better = true; is_better;) {
    is_better = false;
    const double least = LeastSeparation(table, chosen);
    for (std::size_t i = 0; i < chosen.size() && !is_better; ++i) {
      if (table.Nearest(chosen[i], chosen, i) > least) continue;
      for (std::size_t other = 0; other < table.size() && !is_better; ++other) {
        if (table.Nearest(other, chosen, i) <= least) continue;
        const std::size_t before = std::exchange(chosen[i], other);
        is_better = LeastSeparation(table, chosen) > least;
        if (!is_better) chosen[i] = before;
      }
    }
  }
}

std::vector<std::size_t> BestOfCount(const SeparationTable& table, std::size_t count) {
  std::vector<std::size_t> best;
  double best_least = -1;
  for (std::size_t s = 0; s < std::min(kStarts, table.size()); ++s) {
    auto chosen = FarthestFirst(table, s * table.size() / std::min(kStarts, table.size()), count, 0);
    if (chosen.size() < count) continue;
    Spread(table, chosen);
    const double least = LeastSeparation(table, chosen);
    if (least > best_least) best = chosen, best_least = least;
  }
  return best;
}

std::vector<std::size_t> MostThatFit(const SeparationTable& table, double needed) {
  std::vector<std::size_t> most;
  const std::size_t starts = std::min(kStarts, table.size());
  for (std::size_t s = 0; s < starts; ++s) {
    for (auto chosen : {DensestFrom(table, s * table.size() / starts, needed),
                        FarthestFirst(table, s * table.size() / starts, kFittingMax, needed)}) {
      if (chosen.size() > most.size()) most = std::move(chosen);
    }
  }
  return most;
}

std::string Metres(double value) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(2) << value << " m";
  return text.str();
}

base::Error NothingFits(const DesignOrder& order, double gap_m) {
  return {base::ErrorCode::kFailed, "--length-m " + Metres(order.length_m),
          "holds no four LEDs that keep " + Metres(gap_m) + " apart (what does not merge at " +
              Metres(order.distance_m) +
              ") and tell their direction; take a longer bar, a shorter distance or less lean"};
}

}  // namespace

base::Result<TargetDesign> DesignTargets(const DesignOrder& order) {
  TargetDesign design;
  const double px_per_m = order.view.focal_px * std::cos(order.view.tilt_max_rad) / order.distance_m;
  const double merge_m = kMergeSigmas * order.spot_sigma_px / px_per_m;
  design.gap_m = std::max(order.gap_min_m, std::ceil(merge_m / kCentimetre - 1e-9) * kCentimetre);
  design.gap_px = design.gap_m * px_per_m;
  design.needed_sigmas = NeededSigmas(order.view.noise_px);
  std::vector<base::Target> layouts;
  for (const double step : {1.0, 2.0, 5.0, 10.0, 20.0, 50.0}) {
    design.step_m = step * kCentimetre;
    layouts = LayoutsOf(order, design.gap_m, design.step_m);
    if (layouts.size() <= kLayoutsMax) break;
  }
  if (layouts.empty()) return NothingFits(order, design.gap_m);
  design.layouts = layouts.size();
  const SeparationTable table(layouts, order);
  const auto most = MostThatFit(table, design.needed_sigmas);
  design.fitting = most.size();
  if (order.count > static_cast<int>(design.fitting)) {
    return base::Error{base::ErrorCode::kFailed, "--count " + std::to_string(order.count),
                       "is more than fit: " + std::to_string(design.fitting) + " bars of " +
                           Metres(order.length_m) + " can be told apart at " + Metres(order.distance_m) +
                           "; take longer bars, a shorter distance or less lean"};
  }
  std::vector<std::size_t> chosen =
      order.count > 0 ? BestOfCount(table, static_cast<std::size_t>(order.count)) : most;
  if (chosen.empty()) chosen.assign(most.begin(), most.begin() + order.count);
  std::sort(chosen.begin(), chosen.end());
  design.separation_sigmas = LeastSeparation(table, chosen);
  for (const std::size_t i : chosen) {
    base::Target target = layouts[i];
    std::ostringstream name;
    name << "bar_" << std::setw(2) << std::setfill('0') << design.targets.size() + 1;
    target.name = name.str();
    design.targets.push_back(target);
  }
  return design;
}

std::string FormatDesign(const TargetDesign& design, const DesignOrder& order) {
  constexpr double kDegOfRad = 180 / 3.14159265358979323846;
  std::ostringstream text;
  text << std::fixed << std::setprecision(2) << design.fitting
       << (design.fitting == kFittingMax ? " or more" : "") << " bars of " << order.length_m
       << " m can be told apart up to " << std::setprecision(0) << order.distance_m << " m, leaning up to "
       << order.view.tilt_max_rad * kDegOfRad << " deg, with centroids of " << std::setprecision(3)
       << order.view.noise_px << " px (" << design.layouts << " layouts on multiples of "
       << std::setprecision(2) << design.step_m << " m compared)\n"
       << "smallest gap " << design.gap_m << " m: " << std::setprecision(1) << design.gap_px
       << " px there; spots of " << order.spot_sigma_px << " px merge below "
       << kMergeSigmas * order.spot_sigma_px << " px\n"
       << design.targets.size() << " bars; the nearest two, and the directions, are "
       << design.separation_sigmas << " sigmas apart in one image (" << design.needed_sigmas
       << " are needed)\n";
  for (const base::Target& target : design.targets) {
    text << "  " << target.name << "  leds_m: [" << std::setprecision(2);
    for (std::size_t i = 0; i < target.leds_m.size(); ++i) text << (i == 0 ? "" : ", ") << target.leds_m[i];
    text << "]\n";
  }
  return text.str();
}

}  // namespace adit::host
