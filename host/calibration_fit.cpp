#include "host/calibration_fit.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace adit::host {
namespace {

// chi2 of a right bar: 16 residuals, 5 parameters of its own. Median and 99.9 % of 11 degrees of freedom; of
// a light at rest: 1 degree.
constexpr double kChi2Median = 10.34, kChi2Max = 31.3, kPointChi2Max = 10.8;
constexpr double kSigma0Min = 0.1;  // centroids ten times better than promised are exact ones
constexpr int kRejectRounds = 4;

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// sigma0 by the median, which wrong pairs do not move.
double MedianSigma0(const Bundle& bundle) { return std::sqrt(Median(bundle.chi2) / kChi2Median); }

/// Bars within the gate, of several candidates of one frame and target the best; lights within theirs.
Placed KeepRight(const Placed& placed, const Bundle& bundle, std::vector<StereoBar>& misfits) {
  const double scale = std::pow(std::max(kSigma0Min, MedianSigma0(bundle)), 2);
  std::map<BarKey, std::size_t> best;
  for (std::size_t i = 0; i < placed.bars.size(); ++i) {
    if (!(bundle.chi2[i] <= kChi2Max * scale)) continue;
    const auto [entry, is_new] = best.emplace(KeyOf(placed.bars[i]), i);
    if (!is_new && bundle.chi2[i] < bundle.chi2[entry->second]) entry->second = i;
  }
  Placed kept;
  kept.state = bundle.state;
  kept.state.places.clear(), kept.state.points_l_m.clear();
  for (std::size_t i = 0; i < placed.bars.size(); ++i) {
    const auto entry = best.find(KeyOf(placed.bars[i]));
    if (entry == best.end() || entry->second != i) misfits.push_back(placed.bars[i]);
  }
  for (const auto& [key, i] : best) {
    kept.bars.push_back(placed.bars[i]);
    kept.state.places.push_back(bundle.state.places[i]);
  }
  for (std::size_t i = 0; i < placed.points.size(); ++i) {
    if (!(bundle.point_chi2[i] <= kPointChi2Max * scale)) continue;
    kept.points.push_back(placed.points[i]);
    kept.state.points_l_m.push_back(bundle.state.points_l_m[i]);
  }
  return kept;
}

}  // namespace

Placed Place(const BundleSetting& setting, const optics::Rig& rig, std::span<const StereoBar> bars,
             std::span<const StereoPoint> points) {
  Placed placed;
  placed.state = {rig.left, rig.right, rig.T_r_l, std::vector<double>(setting.targets.size(), 1.0), {}, {}};
  for (const StereoBar& bar : bars) {
    if (const auto place = PlaceBar(rig, bar, setting.targets[bar.target])) {
      placed.bars.push_back(bar);
      placed.state.places.push_back(*place);
    }
  }
  for (const StereoPoint& point : points) {
    const auto place = Triangulate(
        rig.T_r_l, {rig.left.Normalised(point.left.ideal_px), rig.right.Normalised(point.right.ideal_px)});
    if (!place || !(place->depth_left > 0) || !(place->depth_right > 0)) continue;
    placed.points.push_back(point);
    placed.state.points_l_m.push_back(place->point_l);
  }
  return placed;
}

std::optional<CalibrationFit> FitCalibration(const BundleSetting& setting, Placed placed,
                                             std::size_t bars_min) {
  CalibrationFit fit;
  fit.setting = setting;
  for (int round = 0; round < kRejectRounds && placed.bars.size() >= bars_min; ++round) {
    const auto bundle =
        AdjustBundle(setting, {placed.bars, placed.points}, placed.state, BundleLoss::kRobust);
    if (!bundle) return std::nullopt;
    Placed kept = KeepRight(placed, *bundle, fit.misfits);
    const bool is_settled =
        kept.bars.size() == placed.bars.size() && kept.points.size() == placed.points.size();
    fit.setting.noise_scale = setting.noise_scale * std::max(1.0, MedianSigma0(*bundle));
    placed = std::move(kept);
    if (is_settled) break;
  }
  if (placed.bars.size() >= bars_min) {
    auto bundle = AdjustBundle(fit.setting, {placed.bars, placed.points}, placed.state, BundleLoss::kLeast);
    if (!bundle) return std::nullopt;
    fit.bundle = std::move(*bundle);
  }
  fit.bars = std::move(placed.bars);
  fit.points = std::move(placed.points);
  return fit;
}

}  // namespace adit::host
