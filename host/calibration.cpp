#include "host/calibration.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "host/calibration_fit.h"
#include "host/calibration_verdict.h"
#include "host/essential.h"
#include "host/pair_consensus.h"

namespace adit::host {
namespace {

using base::Error;
using base::ErrorCode;

constexpr double kCoverageMinPct = 10;  // 5 of 48 cells: a bar that stays in one place touches fewer

Error Refusal(const CalibrationInput& input, const std::string& detail) {
  const std::size_t more = input.recordings.size() - 1;
  return {ErrorCode::kFailed,
          input.recordings.front() + (more > 0 ? " and " + std::to_string(more) + " more" : ""), detail};
}

RayBar Rays(const CalibrationInput& input, const StereoBar& bar) {
  RayBar rays;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    rays[i] = {input.left.Normalised(bar.left[i].ideal_px), input.right.Normalised(bar.right[i].ideal_px)};
  }
  return rays;
}

/// LED 1 to LED 4 as measured, each end triangulated on its own.
double MeasuredLengthM(const CalibrationInput& input, const RelativePose& pose, const StereoBar& bar) {
  const RayBar rays = Rays(input, bar);
  const auto first = Triangulate(pose, rays.front());
  const auto last = Triangulate(pose, rays.back());
  return first && last ? (last->point_l - first->point_l).norm() : std::numeric_limits<double>::quiet_NaN();
}

/// Bars that may be right, and the wrong ones by name.
struct Sieve {
  std::vector<StereoBar> bars;
  std::vector<WrongPair> wrong;
};

WrongPair Wrong(const StereoBar& bar, const std::string& reason) {
  return {bar.recording, bar.mid_exposure_ns, bar.target, reason};
}

Sieve Similar(const CalibrationInput& input, double angle_max_rad) {
  Sieve out;
  for (const StereoBar& bar : input.bars) {
    if (LooksSimilar(bar, angle_max_rad)) {
      out.bars.push_back(bar);
    } else {
      out.wrong.push_back(Wrong(bar, "points another way in the other image"));
    }
  }
  return out;
}

/// The relative pose with metres: known bar over its mean measured length (seed eq. 4.1), the mean taken over
/// the middle half, because a wrong pair can be any length.
std::optional<RelativePose> ScaledPose(const CalibrationInput& input, const Consensus& consensus,
                                       const std::vector<StereoBar>& bars) {
  std::vector<RayPair> points;
  for (const std::size_t i : consensus.bars) {
    for (const RayPair& led : Rays(input, bars[i])) points.push_back(led);
  }
  auto pose = ChoosePose(consensus.essential, points);
  if (!pose) return std::nullopt;
  std::vector<double> lengths;  // in units of baseline per metre of bar
  for (const std::size_t i : consensus.bars) {
    const double length = MeasuredLengthM(input, *pose, bars[i]) / input.targets[bars[i].target].LengthM();
    if (std::isfinite(length)) lengths.push_back(length);
  }
  if (lengths.empty()) return std::nullopt;
  std::sort(lengths.begin(), lengths.end());
  const std::size_t from = lengths.size() / 4, to = lengths.size() - from;
  double sum = 0;
  for (std::size_t i = from; i < to; ++i) sum += lengths[i];
  pose->translation_m /= sum / static_cast<double>(to - from);
  return pose;
}

std::string TooFew(std::size_t found, std::size_t wanted, const std::string& what) {
  return std::to_string(found) + " " + what + "; at least " + std::to_string(wanted) +
         " are needed: wave the bar longer, in view of both cameras";
}

/// Why the bars cannot hold a pose before any is sought; empty if they may.
std::string Concentrated(const CalibrationInput& input, const std::vector<StereoBar>& bars) {
  const double left_pct = CoveragePct(bars, input.left, &StereoBar::left);
  const double right_pct = CoveragePct(bars, input.right, &StereoBar::right);
  const bool is_left = left_pct < right_pct;
  const double least_pct = std::min(left_pct, right_pct);
  if (least_pct >= kCoverageMinPct) return "";
  return "the bars touch " + std::to_string(std::lround(least_pct)) + " % of " + (is_left ? "cam0" : "cam1") +
         "'s image; at least 10 % are needed: wave the bar through the whole of both images, near and far";
}

/// The bars of one epipolar geometry, and the rig that they start the adjustment from.
struct Start {
  std::vector<StereoBar> bars;
  RelativePose T_r_l;
};

base::Result<Start> FindStart(const CalibrationInput& input, const CalibrationOptions& options,
                              Sieve& sieve) {
  std::vector<RayBar> rays;
  for (const StereoBar& bar : sieve.bars) rays.push_back(Rays(input, bar));
  const double focal_px =
      0.25 * (input.left.fu_px + input.left.fv_px + input.right.fu_px + input.right.fv_px);
  const auto consensus = FindConsensus(rays, focal_px, {});
  if (!consensus || consensus->bars.size() < options.bars_min) {
    return Refusal(input, TooFew(consensus ? consensus->bars.size() : 0, options.bars_min,
                                 "bars agree on one epipolar geometry"));
  }
  const auto pose = ScaledPose(input, *consensus, sieve.bars);
  if (!pose)
    return Refusal(input, "no relative pose has the bars in front of both cameras; is one image mirrored?");
  Start start{{}, *pose};
  std::size_t next = 0;
  for (std::size_t i = 0; i < sieve.bars.size(); ++i) {
    if (next < consensus->bars.size() && consensus->bars[next] == i) {
      start.bars.push_back(sieve.bars[i]);
      ++next;
    } else {
      sieve.wrong.push_back(Wrong(sieve.bars[i], "off the epipolar lines"));
    }
  }
  return start;
}

/// Every n-th frame and target is held out, with all its candidates, if enough stay.
void HoldOutSome(const CalibrationOptions& options, std::vector<StereoBar>& bars,
                 std::vector<StereoBar>& held_out) {
  std::set<BarKey> keys;
  for (const StereoBar& bar : bars) keys.insert(KeyOf(bar));
  const std::size_t every = options.hold_out_every;
  if (every == 0 || keys.size() - keys.size() / every < options.bars_min) return;
  std::set<BarKey> held;
  std::size_t count = 0;
  for (const BarKey& key : keys) {
    if (++count % every == 0) held.insert(key);
  }
  const auto first = std::stable_partition(
      bars.begin(), bars.end(), [&held](const StereoBar& bar) { return held.count(KeyOf(bar)) == 0; });
  held_out.assign(first, bars.end());
  bars.erase(first, bars.end());
}

/// By time, and a candidate only if no other one of its frame and target was right.
std::vector<WrongPair> Named(std::vector<WrongPair> wrong, const std::vector<StereoBar>& used,
                             const HoldOut& held_out) {
  std::set<BarKey> found;
  for (const StereoBar& bar : used) found.insert(KeyOf(bar));
  for (const HeldBar& bar : held_out.bars) found.insert(bar.key);
  const auto key = [](const WrongPair& pair) {
    return BarKey{static_cast<std::uint16_t>(pair.recording), pair.mid_exposure_ns,
                  static_cast<std::uint8_t>(pair.target)};
  };
  wrong.erase(std::remove_if(wrong.begin(), wrong.end(),
                             [&](const WrongPair& pair) { return found.count(key(pair)) > 0; }),
              wrong.end());
  std::stable_sort(wrong.begin(), wrong.end(),
                   [&](const WrongPair& a, const WrongPair& b) { return key(a) < key(b); });
  return wrong;
}

/// Similar bars, or why there are too few.
base::Result<Sieve> Screen(const CalibrationInput& input, const CalibrationOptions& options,
                           std::size_t bars_seen) {
  if (bars_seen < options.bars_min)
    return Refusal(input, TooFew(bars_seen, options.bars_min, "bars identified in both images"));
  Sieve similar = Similar(input, options.similarity_max_rad);
  if (similar.bars.size() < options.bars_min) {
    return Refusal(input,
                   TooFew(similar.bars.size(), options.bars_min,
                          "bars have a similar direction in both images (a mirrored or turned image?)"));
  }
  if (const std::string reason = Concentrated(input, similar.bars); !reason.empty())
    return Refusal(input, reason);
  return similar;
}

std::vector<StereoPoint> PairLights(const CalibrationInput& input, const optics::Rig& rig, double gate_px) {
  std::vector<StereoPoint> points;
  for (const RestLights& lights : input.lights) {
    for (const StereoPoint& point : MatchLights(lights, rig, gate_px)) points.push_back(point);
  }
  return points;
}

/// The same adjustment with the lights at rest that its rig pairs; as it was without any.
std::optional<CalibrationFit> WithLights(const CalibrationInput& input, CalibrationFit fit,
                                         std::size_t bars_min) {
  // Bars in the middle leave the corners wrong by some tenths of a pixel. With the lights that are paired for
  // all that, the others have fewer partners to be mistaken for.
  for (const double gate_px : {1.0, 0.2}) {
    if (fit.bars.size() < bars_min) break;
    const optics::Rig rig{fit.bundle.state.left, fit.bundle.state.right, fit.bundle.state.T_r_l, ""};
    const auto points = PairLights(input, rig, gate_px);
    if (points.empty()) break;
    auto again = FitCalibration(fit.setting, Place(fit.setting, rig, fit.bars, points), bars_min);
    if (!again) return std::nullopt;
    again->misfits.insert(again->misfits.end(), fit.misfits.begin(), fit.misfits.end());
    fit = std::move(*again);
  }
  return fit;
}

}  // namespace

base::Result<Calibration> Calibrate(const CalibrationInput& input, const CalibrationOptions& options) {
  std::set<BarKey> seen;
  for (const StereoBar& bar : input.bars) seen.insert(KeyOf(bar));
  auto sieve = Screen(input, options, seen.size());
  if (!sieve) return sieve.error();
  auto start = FindStart(input, options, *sieve);
  if (!start) return start.error();
  std::vector<StereoBar> held_out;
  HoldOutSome(options, start->bars, held_out);
  const BundleSetting setting{
      input.left, input.right, input.left_prior, input.right_prior, input.targets, input.bar_sigma_m, 1};
  auto fit =
      FitCalibration(setting, Place(setting, {input.left, input.right, start->T_r_l, ""}, start->bars, {}),
                     options.bars_min);
  if (fit) fit = WithLights(input, std::move(*fit), options.bars_min);
  if (!fit)
    return Refusal(input,
                   "the bundle adjustment does not converge: do the camera files belong to these cameras, "
                   "the models to these bars?");
  if (fit->bars.size() < options.bars_min)
    return Refusal(input, TooFew(fit->bars.size(), options.bars_min, "bars fit one relative pose"));
  if (!fit->bundle.covariance) {
    return Refusal(input, "the bars leave the relative pose undetermined; move the bar through the volume");
  }
  Calibration calibration = Conclude(input, *fit, held_out);
  calibration.quality.bars_seen = seen.size();
  if (const std::string reason = Refuses(calibration); !reason.empty()) return Refusal(input, reason);
  for (const StereoBar& bar : fit->misfits) sieve->wrong.push_back(Wrong(bar, "fits no place of the bar"));
  for (const StereoBar& bar : calibration.quality.hold_out.misfits)
    sieve->wrong.push_back(Wrong(bar, "held out, fits no place of the bar"));
  calibration.wrong = Named(std::move(sieve->wrong), fit->bars, calibration.quality.hold_out);
  calibration.reservations = Reservations(calibration);
  calibration.verdict = calibration.reservations.empty() ? Verdict::kGood : Verdict::kUsable;
  return calibration;
}

}  // namespace adit::host
