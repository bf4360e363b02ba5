#include "firmware/stereo/triple_bars.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "firmware/stereo/lit_place.h"
#include "firmware/stereo/reflected_lights.h"

namespace adit::stereo {

using base::kLedCount;

namespace {

/// The LED that a triple does not show.
std::size_t FourthOf(const Triple& triple) {
  const auto& taken = triple.blobs[0];
  return static_cast<std::size_t>(std::find(taken.begin(), taken.end(), kNoBlob) - taken.begin());
}

}  // namespace

TripleBars::TripleBars(const optics::Rig& rig, const std::vector<base::Target>& targets,
                       const LocatorOptions& options)
    : targets_(targets),
      rig_(rig),
      views_(MakeViews(rig)),
      options_(options),
      other_readings_(rig, targets, options),
      cloud_(rig, options),
      search_(rig, targets, options) {}

void TripleBars::Run(const std::bitset<identify::kMaxTargets>& wanted, const BarBuilder& builder,
                     const Correspondence& correspondence, const BlobFlags& anothers,
                     std::vector<Finding>& findings) {
  if (wanted.none()) return;
  wanted_ = wanted, anothers_ = anothers;
  Claim(findings);
  cloud_.Build(builder.Blobs(0), builder.Blobs(1), claimed_, correspondence);
  for (std::size_t i = 0; i < findings.size(); ++i) {
    if (wanted[i]) DropDoubtful(i, builder, findings[i]);
  }
  search_.Run(cloud_, wanted, triples_);
  if (triples_.cut_short) return;
  bars_.clear();
  for (const Triple& triple : triples_.triples) Try(triple, builder, findings);
  if (bars_.empty()) return;
  for (const Bar& bar : bars_) {
    Finding& finding = findings[bar.triple.target];
    // All four LEDs in both images are as good as those that the left image showed first.
    const bool believed =
        bar.solution.complete ||
        (!IsAnothers(bar) && !ReflectsLights(bar.solution, cloud_, builder.Blobs(0), options_) &&
         triples_.chance[bar.triple.target] <= options_.chance_max && StandsInItsLine(bar, builder));
    if (bars_.Full() || !believed || IsInDoubt(bar, builder)) {
      // It came as far as any hypothesis can.
      if (finding.solutions.empty()) finding.reason = LossReason::kAmbiguous;
      continue;
    }
    Add(options_, bar.solution, finding);
  }
}

/// Of a target that is not followed, what two lights show in a mirror, and four lights that are not alike
/// while three LEDs may be among them.
void TripleBars::DropDoubtful(std::size_t target, const BarBuilder& builder, Finding& finding) const {
  const auto is_doubtful = [&](const Solution& s) {
    if (ReflectsLights(s, cloud_, builder.Blobs(0), options_)) return true;
    return !SameBrightness(LedFlux{}, s.points.flux_dn) &&
           other_readings_.Exist({&s, target, wanted_}, builder);
  };
  std::size_t kept = 0;
  for (std::size_t i = 0; i < finding.solutions.size(); ++i) {
    if (!is_doubtful(finding.solutions[i])) finding.solutions[kept++] = finding.solutions[i];
  }
  if (kept < finding.solutions.size()) finding.reason = LossReason::kAmbiguous;
  finding.solutions.Truncate(kept);
}

void TripleBars::Claim(const std::vector<Finding>& findings) {
  for (auto& flags : claimed_) flags.reset();
  for (const Finding& finding : findings) {
    for (const Solution& solution : finding.solutions) {
      if (!solution.complete) continue;
      for (std::size_t side = 0; side < 2; ++side) {
        for (const std::uint16_t blob : solution.points.blobs[side]) claimed_[side].set(blob);
      }
    }
  }
}

void TripleBars::Try(const Triple& triple, const BarBuilder& builder, const std::vector<Finding>& findings) {
  const auto explains = [&triple](const Solution& s) { return Explains(s, triple.blobs); };
  const auto& known = findings[triple.target].solutions;
  if (std::any_of(known.begin(), known.end(), explains)) return;
  LossReason unused;
  const base::Target& target = targets_[triple.target];
  const auto bar = builder.Build(target, triple.blobs, unused);
  if (!bar || bar->chi_square > ChiSquareLimit(2 * bar->seen - 5, options_.candidate_sigmas)) return;
  if (!SameBrightness(LedFlux{}, bar->points.flux_dn)) return;
  Bar all{triple, builder.Completed(target, *bar, LedFlux{})};
  all.solution.points.target = triple.target;
  bars_.push_back(all);
}

/// Lights on the bar's line in space, up to a length beyond its ends, that are not its LEDs. One just where
/// the fourth LED is, only of other brightness, is that LED. Full if there may be more.
TripleBars::LineLights TripleBars::LightsInLine(const Bar& bar, const detect::BlobSet& left) const {
  const base::Target& target = targets_[bar.triple.target];
  const auto& fit = bar.solution.fit;
  const auto& blobs = bar.solution.points.blobs;
  LineLights others;
  for (std::size_t i = 0; i < cloud_.size() && !others.Full(); ++i) {
    const CloudPoint& c = cloud_[i];
    const auto is_led = [&](std::size_t side) {
      return std::find(blobs[side].begin(), blobs[side].end(), c.blobs[side]) != blobs[side].end();
    };
    if (is_led(0) || is_led(1)) continue;
    // Where the line of sight of the left camera, at the rig's origin, passes the bar's line nearest.
    const Eigen::Vector3d start_m = fit.PointM(target, 0), ray = c.point_b_m.normalized();
    const Eigen::Vector3d across = fit.bar.direction_b - ray.dot(fit.bar.direction_b) * ray;
    const double place_m = -across.dot(start_m) / across.squaredNorm();
    if (!(place_m > -target.LengthM() && place_m < 2 * target.LengthM())) continue;
    const double noise_px = options_.sigmas * 2 * c.noise_px;
    const auto stands_at = [&](double at_m) {
      bool stands = true;
      for (std::size_t side = 0; side < 2; ++side) {
        Eigen::Vector2d px;
        Eigen::Matrix<double, 2, 3> slope;
        stands = stands && views_[side].Project(fit.PointM(target, at_m), px, slope) &&
                 (px - c.px[side]).norm() <= noise_px + (side == 1 ? 0.5 * options_.epipolar_px : 0);
      }
      return stands;
    };
    if (stands_at(place_m) && !stands_at(target.leds_m[FourthOf(bar.triple)]))
      others.push_back({place_m, left.blobs[c.blobs[0]].flux_dn});
  }
  return others;
}

/// Whether the three LEDs and the lights beside them are alike and stand at even steps, as lamps in a row do.
/// Where the step fits, some three of a row stand exactly as LEDs do, in every pair.
bool TripleBars::IsRow(const Bar& bar, const LineLights& others) const {
  constexpr double kEven = 0.1;      // of a step: lamps are hung by hand
  constexpr double kHiddenMost = 3;  // steps between neighbours: two lamps in succession may be hidden
  const std::size_t fourth = FourthOf(bar.triple);
  const auto& leds_m = targets_[bar.triple.target].leds_m;
  base::FixedVector<double, kLedCount - 1 + LineLights::kCapacity> places_m;
  for (const LineLight& other : others) {
    const double ratio = other.flux_dn / bar.solution.flux_dn;
    if (ratio > kSameMake || ratio * kSameMake < 1) return false;
    places_m.push_back(other.place_m);
  }
  if (places_m.empty()) return false;
  for (std::size_t i = 0; i < kLedCount; ++i) {
    if (i != fourth) places_m.push_back(leds_m[i]);
  }
  std::partial_sort(places_m.begin(), places_m.end(), places_m.end());
  std::adjacent_difference(places_m.begin(), places_m.end(), places_m.begin());
  const double step_m = *std::min_element(places_m.begin() + 1, places_m.end());
  return std::all_of(places_m.begin() + 1, places_m.end(), [step_m](double gap_m) {
    const double steps = std::round(gap_m / step_m);
    return steps <= kHiddenMost && std::abs(gap_m - steps * step_m) <= kEven * step_m;
  });
}

/// Whether nothing that could hide the triple's fourth LED reaches to where it is in an image: what it merged
/// with is brighter than it is.
bool TripleBars::IsDark(const Bar& bar, const BarBuilder& builder, std::size_t side) const {
  constexpr double kBesidePx = 2;  // nearer two lights are one, or are not measured well
  const base::Target& target = targets_[bar.triple.target];
  const Eigen::Vector3d led_b_m = bar.solution.fit.PointM(target, target.leds_m[FourthOf(bar.triple)]);
  const auto& flux_dn = bar.solution.points.flux_dn[side];
  const double typical_dn = *std::max_element(flux_dn.begin(), flux_dn.end());
  return !IsLit(rig_, builder.Blobs(side), side, led_b_m, {kBesidePx, typical_dn / kSameMake});
}

/// Alone on its line a triple needs no more: chance does not make it. With other lights on the line some
/// three of them may stand as three LEDs do; then the fourth LED must be accounted for: it is seen in one
/// image, or lights that hide it stand in both, and the lights are no row of lamps. Of many lights nothing is
/// concluded.
bool TripleBars::StandsInItsLine(const Bar& bar, const BarBuilder& builder) const {
  const LineLights others = LightsInLine(bar, builder.Blobs(0));
  if (others.empty()) return true;
  if (others.Full()) return false;
  if (bar.solution.seen > 2 * 3) return true;
  return !IsRow(bar, others) && !IsDark(bar, builder, 0) && !IsDark(bar, builder, 1);
}

/// Whether two of its lights stand where another target, one that is followed, is expected to have LEDs.
bool TripleBars::IsAnothers(const Bar& bar) const {
  int count = 0;
  for (std::size_t i = 0; i < kLedCount; ++i) {
    const auto is_marked = [&](std::size_t side) {
      const std::uint16_t blob = bar.solution.points.blobs[side][i];
      return blob != kNoBlob && anothers_[side][blob];
    };
    count += is_marked(0) && is_marked(1) ? 1 : 0;
  }
  return count >= 2;
}

/// Contested now or, as long as three LEDs show there, a moment ago: that one reading's LEDs are hidden now
/// does not make the other one right.
bool TripleBars::IsInDoubt(const Bar& bar, const BarBuilder& builder) {
  constexpr base::DurationNs kMomentNs = base::kNsPerS;
  constexpr double kNearM = 1;  // a machine does not go farther between two pairs that show it
  const base::TimeNs now_ns = builder.Blobs(0).stamp.mid_exposure_ns;
  const auto is_old = [now_ns](const Doubt& doubt) {
    return doubt.seen_ns > now_ns || now_ns - doubt.seen_ns > kMomentNs;
  };
  const Eigen::Vector3d& place_b_m = bar.solution.points.epicenter_b_m;
  Doubt* at = std::find_if(doubts_.begin(), doubts_.end(), [&](const Doubt& doubt) {
    return !is_old(doubt) && doubt.target == bar.triple.target &&
           (doubt.epicenter_b_m - place_b_m).norm() < kNearM;
  });
  const bool in_doubt = IsContested(bar, builder) || (!bar.solution.complete && at != doubts_.end());
  if (!in_doubt) return false;
  if (at == doubts_.end()) at = std::find_if(doubts_.begin(), doubts_.end(), is_old);
  const Doubt doubt{bar.triple.target, place_b_m, now_ns};
  if (at != doubts_.end())
    *at = doubt;
  else
    doubts_.push_back(doubt);
  return true;
}

/// Another target may be seen in the same blobs, or this one elsewhere, whether or not that is believed.
bool TripleBars::IsContested(const Bar& bar, const BarBuilder& builder) const {
  const double cost_max = bar.solution.cost + options_.chi_square_margin;
  const auto contests = [&](const Bar& other) {
    return other.triple.target != bar.triple.target && ShareABlob(other.solution, bar.solution) &&
           other.solution.cost < cost_max;
  };
  return std::any_of(bars_.begin(), bars_.end(), contests) ||
         (!bar.solution.complete &&
          other_readings_.Exist({&bar.solution, bar.triple.target, wanted_}, builder));
}

}  // namespace adit::stereo
