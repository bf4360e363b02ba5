// The cases of the suite `watch`.
#include <algorithm>
#include <array>
#include <cmath>
#include <iomanip>
#include <optional>
#include <sstream>
#include <vector>

#include "firmware/watch/watch.h"
#include "host/confidence.h"
#include "host/crew.h"
#include "host/seed_bound.h"
#include "host/simulated_blobs.h"
#include "host/watch_suite.h"
#include "host/watch_traffic.h"

namespace adit::host {
namespace {

using Eigen::Vector3d;

constexpr double kRadPerMicro = 1e-6, kPeakDn = 200, kSecondsPerHour = 3600;
constexpr double kStepUrad = 10, kFoundWithinS = 30;
/// By then both references are learned, a pair lost now and then.
constexpr double kLearnedS = 1.05 * watch::WatchOptions{}.learn_s;

/// 1 sigma of a calibration as good as they come (bounds 2.5): pitch, yaw, roll, shift.
watch::Motion CalibrationSigmas() {
  watch::Motion sigmas;
  sigmas << 2e-6, 30e-6, 4e-6, 1e-3, 1e-3, 1e-3;
  return sigmas;
}

/// Of (rotation, translation of T_r_l): a shift of the centre is one of the translation, turned.
watch::MotionMatrix CalibrationCovariance(const optics::Rig& rig) {
  watch::MotionMatrix by_motion = watch::MotionMatrix::Identity();
  by_motion.bottomLeftCorner<3, 3>() = -base::Skew(rig.T_r_l.translation_m);
  by_motion.bottomRightCorner<3, 3>() = -rig.T_r_l.rotation;
  const watch::MotionMatrix own = CalibrationSigmas().cwiseAbs2().asDiagonal();
  return by_motion * own * by_motion.transpose();
}

/// A watch and what it sees, from a start with a calibration that is wrong by as much as it says.
class Post {
 public:
  Post(const TrafficPlan& plan, std::uint64_t seed)
      : plan_(plan), traffic_(plan, seed), watch_(MakeWatch(plan, traffic_.Calibrated())) {
    for (Eigen::Index i = 0; i < 6; ++i) start_[i] = CalibrationSigmas()[i] * traffic_.Draw().Normal();
    Move(Vector3d::Zero(), Vector3d::Zero());
  }

  /// Since the start.
  void Move(const Vector3d& turn_rad, const Vector3d& shift_b_m) {
    traffic_.Move(start_.head<3>() + turn_rad, start_.tail<3>() + shift_b_m);
  }
  const watch::Finding& Next() {
    watch_.Add(traffic_.Next());
    return watch_.Latest();
  }
  const WatchTraffic& Traffic() const { return traffic_; }
  double Draw(double from, double to) { return traffic_.Draw().Uniform(from, to); }
  Vector3d DrawVector(double sigma) {
    const double x = traffic_.Draw().Normal(), y = traffic_.Draw().Normal();
    return sigma * Vector3d(x, y, traffic_.Draw().Normal());
  }
  std::size_t Pairs(double seconds) const {
    return static_cast<std::size_t>(std::lround(seconds * plan_.rate_hz));
  }

 private:
  static watch::Watch MakeWatch(const TrafficPlan& plan, const optics::Rig& rig) {
    const auto targets = WatchTraffic::Targets();
    watch::WatchOptions options;
    options.rate_hz = plan.rate_hz;
    return {rig, {targets.begin(), targets.end()}, options, CalibrationCovariance(rig)};
  }

  TrafficPlan plan_;
  WatchTraffic traffic_;
  watch::Watch watch_;
  watch::Motion start_ = watch::Motion::Zero();
};

bool HasChanged(const watch::Finding& finding) { return finding.verdict == watch::Verdict::kChanged; }

/// The bound of the yaw: every sight of a bar, the reference known, the rig free to shift as the watch
/// allows.
class YawBound {
 public:
  void Add(const WatchTraffic& traffic, double noise_px, double times) {
    for (std::size_t i = 0; i < 2; ++i)
      information_ += times / (noise_px * noise_px) *
                      BarInformation(traffic.Calibrated(), WatchTraffic::Targets()[i], traffic.Poses()[i]);
  }
  double SigmaRad(const optics::Rig& rig) const {
    watch::MotionMatrix by_motion = watch::MotionMatrix::Identity();
    by_motion.bottomLeftCorner<3, 3>() = -base::Skew(rig.T_r_l.translation_m);
    by_motion.bottomRightCorner<3, 3>() = -rig.T_r_l.rotation;
    watch::MotionMatrix all = by_motion.transpose() * information_ * by_motion;
    all.diagonal().tail<3>().array() += std::pow(watch::WatchOptions{}.shift_sigma_m, -2);
    return std::sqrt(all.inverse()(1, 1));
  }

 private:
  PoseInformation information_ = PoseInformation::Zero();
};

struct StepOutcome {
  bool early = false;             ///< called before there was a step
  std::optional<double> found_s;  ///< after the step
  Vector3d error_sigmas = Vector3d::Zero();
  double sigma_urad = 0, bound_urad = 0;  ///< of the yaw, from the 30 s after the step
};

StepOutcome RunStep(std::uint64_t seed, double noise_px) {
  TrafficPlan plan;
  plan.noise_px = noise_px;
  Post post(plan, seed);
  StepOutcome outcome;
  const double step_s = kLearnedS + post.Draw(0, 60);
  for (std::size_t i = 0; i < post.Pairs(step_s); ++i)
    outcome.early = HasChanged(post.Next()) || outcome.early;
  const Vector3d turn_rad = (post.Draw(0, 1) < 0.5 ? 1 : -1) * kStepUrad * kRadPerMicro * Vector3d::UnitY();
  // What the watch allows for happens too, as strongly as it says.
  const Vector3d allowed_rad = post.DrawVector(watch::WatchOptions{}.allowance_rad),
                 shift_m = post.DrawVector(watch::WatchOptions{}.shift_sigma_m);
  post.Move(turn_rad + allowed_rad, shift_m);
  YawBound bound;
  constexpr std::size_t kBoundEvery = 6;
  const watch::Finding* finding = nullptr;
  for (std::size_t i = 0; i < post.Pairs(kFoundWithinS + 1); ++i) {
    finding = &post.Next();
    const double since_s = static_cast<double>(i + 1) / plan.rate_hz;
    if (HasChanged(*finding) && !outcome.found_s) outcome.found_s = since_s;
    if (i % kBoundEvery == 0 && since_s <= kFoundWithinS) bound.Add(post.Traffic(), noise_px, kBoundEvery);
  }
  outcome.error_sigmas =
      (Vector3d(finding->turn_rad.data()) - turn_rad).cwiseQuotient(Vector3d(finding->sigma_rad.data()));
  outcome.sigma_urad = finding->sigma_rad[1] / kRadPerMicro;
  outcome.bound_urad = bound.SigmaRad(post.Traffic().Calibrated()) / kRadPerMicro;
  return outcome;
}

/// Of a standard normal, below x.
double NormalShare(double x) { return 0.5 * std::erfc(-x / std::sqrt(2.0)); }

void ReportSteps(const std::vector<StepOutcome>& outcomes, double noise_px, bool is_bar,
                 SuiteReport& report) {
  std::ostringstream text;
  text << std::setprecision(3) << noise_px << " px: ";
  const std::string at = text.str();
  double found = 0, latest_s = 0, early = 0, squares = 0, sigma = 0, bound = 0, ideal = 0;
  const auto count = static_cast<double>(outcomes.size());
  for (const StepOutcome& outcome : outcomes) {
    early += outcome.early ? 1 : 0;
    found += outcome.found_s && *outcome.found_s <= kFoundWithinS ? 1 : 0;
    latest_s = std::max(latest_s, outcome.found_s.value_or(HUGE_VAL));
    squares += outcome.error_sigmas.y() * outcome.error_sigmas.y();
    sigma += outcome.sigma_urad / count, bound += outcome.bound_urad / count;
    ideal += NormalShare(kStepUrad / outcome.bound_urad - watch::Watch::kAlarm) / count;
  }
  if (is_bar) {
    report.AtLeast(at + "found within 30 s", 100 * found / count, 100, "%", 1);
    report.Inform(at + "the last of them after", latest_s, "s", 1);
  } else {
    report.Inform(at + "found within 30 s", 100 * found / count, "%", 1);
  }
  report.Inform(at + "an ideal test would find", 100 * ideal, "%", 1);
  report.Inform(at + "sigma of the yaw by the bound", bound, "urad");
  report.Inform(at + "the same as stated, over the bound's", sigma / bound);
  report.AtMost(at + "normalised error^2 of the yaw", squares / count, NormalisedErrorLimits(count).high);
  report.AtMost(at + "called before the step", early, 0, "", 0);
}

}  // namespace

SuiteReport MeasureStep(const CaseOrder& order) {
  const std::size_t count = order.CountOr(10);
  SuiteReport report;
  report.how =
      std::to_string(count) +
      " seeds a noise: two machines at 20 to 80 m, 60 pairs a second, yaw of 10 urad at a random time";
  const double honest_px = CentroidNoisePx(kPeakDn);
  const std::vector<double> noises_px{honest_px, 0.02, 0.05};
  const auto outcomes = WorkInParallel<StepOutcome>("step", noises_px.size() * count, [&](std::size_t i) {
    return RunStep(PieceSeed(order, i % count), noises_px[i / count]);
  });
  for (std::size_t n = 0; n < noises_px.size(); ++n) {
    const auto first = outcomes.begin() + static_cast<std::ptrdiff_t>(n * count);
    ReportSteps({first, first + static_cast<std::ptrdiff_t>(count)}, noises_px[n], n == 0, report);
  }
  return report;
}

namespace {

struct QuietOutcome {
  std::size_t alarms = 0;
  double highest = 0;  ///< significance
  std::string first;   ///< alarm
};

std::string Described(const watch::Finding& finding) {
  std::ostringstream text;
  text << std::setprecision(3) << "alarm after " << finding.tracked_s << " s:";
  constexpr std::array kAxes{"pitch", "yaw", "roll"};
  for (std::size_t i = 0; i < kAxes.size(); ++i)
    text << " " << kAxes[i] << " " << finding.turn_rad[i] / kRadPerMicro << " +- "
         << finding.sigma_rad[i] / kRadPerMicro;
  return text.str() + " urad";
}

QuietOutcome RunQuiet(std::uint64_t seed, double seconds) {
  const TrafficPlan plan;
  Post post(plan, seed);
  const Vector3d shift_m = post.DrawVector(watch::WatchOptions{}.shift_sigma_m),
                 turn_rad = post.DrawVector(watch::WatchOptions{}.allowance_rad);
  QuietOutcome outcome;
  const std::size_t pairs = post.Pairs(seconds);
  bool before = false;
  for (std::size_t i = 0; i < pairs; ++i) {
    const double part = static_cast<double>(i) / static_cast<double>(pairs);
    post.Move(part * turn_rad, part * shift_m);
    const watch::Finding& finding = post.Next();
    outcome.highest = std::max(outcome.highest, finding.significance);
    if (HasChanged(finding) && !before && outcome.alarms++ == 0) outcome.first = Described(finding);
    before = HasChanged(finding);
  }
  return outcome;
}

/// Turn (urad) at which a slow one is called; none if not within half an hour.
std::optional<double> RunDrift(std::uint64_t seed) {
  constexpr double kUradPerHour = 20, kPatienceS = 1800;
  const TrafficPlan plan;
  Post post(plan, seed);
  for (std::size_t i = 0; i < post.Pairs(kLearnedS); ++i) post.Next();
  const double sign = post.Draw(0, 1) < 0.5 ? 1 : -1;
  for (std::size_t i = 0; i < post.Pairs(kPatienceS); ++i) {
    const double urad = kUradPerHour * static_cast<double>(i) / plan.rate_hz / kSecondsPerHour;
    post.Move(sign * urad * kRadPerMicro * Vector3d::UnitY(), Vector3d::Zero());
    if (HasChanged(post.Next())) return urad;
  }
  return std::nullopt;
}

}  // namespace

SuiteReport MeasureQuiet(const CaseOrder& order) {
  constexpr std::size_t kPiecesPerHour = 2;
  const std::size_t hours = order.CountOr(2);
  const auto outcomes = WorkInParallel<QuietOutcome>("quiet", hours * kPiecesPerHour, [&](std::size_t i) {
    return RunQuiet(PieceSeed(order, i), kSecondsPerHour / kPiecesPerHour);
  });
  QuietOutcome all;
  SuiteReport report;
  for (const QuietOutcome& outcome : outcomes) {
    if (!outcome.first.empty()) report.findings.push_back(outcome.first);
    all.alarms += outcome.alarms;
    all.highest = std::max(all.highest, outcome.highest);
  }
  report.how =
      std::to_string(hours) +
      " hours of the same traffic in pieces of half an hour, each with its own calibration, bars and "
      "shift; no turn beyond what is allowed";
  report.AtMost("false alarms", static_cast<double>(all.alarms), 0, "", 0);
  report.Inform("so less often (95 %) than", 1000 * PoissonUpper95(all.alarms) / static_cast<double>(hours),
                "in 1000 h", 1);
  report.Inform("highest significance seen", all.highest);
  report.Inform("that which alarms", watch::Watch::kAlarm);
  return report;
}

SuiteReport MeasureDrift(const CaseOrder& order) {
  const std::size_t count = order.CountOr(4);
  const auto turns = WorkInParallel<std::optional<double>>(
      "drift", count, [&](std::size_t i) { return RunDrift(PieceSeed(order, i)); });
  double found = 0, sum = 0, most = 0;
  for (const auto& turn : turns) {
    if (!turn) continue;
    found += 1, sum += *turn, most = std::max(most, *turn);
  }
  SuiteReport report;
  report.how = std::to_string(count) + " seeds: a yaw that grows by 20 urad an hour";
  report.AtLeast("called within half an hour", 100 * found / static_cast<double>(count), 100, "%", 0);
  report.Inform("mean turn when called", sum / found, "urad", 1);
  report.AtMost("largest turn when called", most, kStepUrad, "urad", 1);
  return report;
}

}  // namespace adit::host
