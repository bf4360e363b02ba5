// The cases that ask for the right name at the right place, and for nothing else.
#include <algorithm>
#include <sstream>

#include "host/crew.h"
#include "host/target_tally.h"
#include "host/tunnel.h"
#include "host/underground_cases.h"

namespace adit::host {
namespace {

constexpr double kPieceRateHz = 60;
constexpr std::size_t kPieceFrames = 60;  // of a piece: one second

Tunnel::Ride RideOf(const base::Target& target) {
  Tunnel::Ride ride;
  ride.seconds = kPieceFrames / kPieceRateHz;
  if (target.LengthM() < 1) ride.nearest_m = 15, ride.farthest_m = 55;  // its LEDs merge beyond
  return ride;
}

/// Hides one LED, two, or all of them for some frames.
void HideSome(Tunnel& tunnel, std::size_t target) {
  sim::Random& draw = tunnel.Draw();
  const double what = draw.Uniform();
  const double from_s = draw.Uniform(0, 0.7), to_s = from_s + draw.Uniform(0.05, 0.4);
  const auto led = static_cast<std::size_t>(draw.Uniform(0, 4));
  const int side = static_cast<int>(draw.Uniform(0, 3));
  if (what < 0.6) tunnel.Hide(target, led, side, {from_s, to_s});
  if (what < 0.15) tunnel.Hide(target, (led + 1 + draw.Next() % 3) % 4, side, {from_s, to_s});
  if (what > 0.85) tunnel.HideAll(target, {from_s, to_s});
}

sim::Scene SwapScene(std::uint64_t seed) {
  Tunnel tunnel(seed, TunnelRig(9));
  const auto targets = TunnelTargets();
  for (const base::Target& target : targets) tunnel.AddTarget(target, RideOf(target));
  const int lamps = 20 + static_cast<int>(tunnel.Draw().Uniform(0, 181)), collinear = lamps / 10;
  tunnel.AddLamps(lamps - collinear);
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const int share = collinear / static_cast<int>(targets.size());
    tunnel.AddCollinear(i, i == 0 ? collinear - 2 * share : share);
    HideSome(tunnel, i);
  }
  return tunnel.Take();
}

std::string Label(const CaseOrder& order, std::size_t piece) {
  return "seed " + std::to_string(order.seed) + " piece " + std::to_string(piece) +
         (ImagingOf(piece) == Imaging::kRendered ? " (rendered)" : "");
}

std::string HowMany(const TargetTally& tally, const std::string& what) {
  std::ostringstream text;
  text << tally.target_frames << " target-frames, " << tally.rendered << " of them rendered; " << what;
  return text.str();
}

TargetTally CountPieces(const CaseOrder& order, const std::string& name, std::size_t pieces,
                        sim::Scene (*scene)(std::uint64_t seed)) {
  const auto models = ModelsOf(TunnelTargets());
  const auto tallies = WorkInParallel<TargetTally>(name, pieces, [&](std::size_t i) {
    Episode episode(scene(PieceSeed(order, i)), models, ImagingOf(i));
    return CountEpisode(episode, kPieceFrames, Label(order, i));
  });
  TargetTally sum;
  for (const TargetTally& tally : tallies) sum.Add(tally);
  return sum;
}

std::size_t PiecesFor(std::size_t target_frames) {
  return std::max<std::size_t>(1, (target_frames + 3 * kPieceFrames - 1) / (3 * kPieceFrames));
}

void ReportWrong(const TargetTally& sum, SuiteReport& report) {
  report.AtMost("swapped names", static_cast<double>(sum.swapped), 0, "", 0);
  report.AtMost("of them told as tracked", static_cast<double>(sum.swapped_tracked), 0, "", 0);
  report.AtMost("tracked, off by more than 5 sigma + 10 mm", static_cast<double>(sum.off_tracked), 0, "", 0);
  report.Inform("recovered, off by more", static_cast<double>(sum.off_recovered), "", 0);
  report.Inform("predicted, off by more", static_cast<double>(sum.off_predicted), "", 0);
  report.Inform("of all these, in rendered images", static_cast<double>(sum.wrong_rendered), "", 0);
}

/// Every light of a tunnel but targets.
sim::Scene LampScene(std::uint64_t seed) {
  Tunnel tunnel(seed, TunnelRig(9));
  sim::Random& draw = tunnel.Draw();
  tunnel.AddLamps(10 + static_cast<int>(draw.Uniform(0, 120)));
  for (int rows = static_cast<int>(draw.Uniform(0, 4)); rows > 0; --rows)
    tunnel.AddRow(4 + static_cast<int>(draw.Uniform(0, 8)));
  for (int cars = static_cast<int>(draw.Uniform(0, 4)); cars > 0; --cars)
    tunnel.AddHeadlights(kPieceFrames / kPieceRateHz);
  if (draw.Uniform() < 0.7) tunnel.AddWater(draw.Uniform(0.1, 0.9), draw.Uniform(0, 0.002));
  return tunnel.Take();
}

struct LampTally {
  std::size_t pairs = 0, rendered = 0, reported = 0;
  std::vector<std::string> findings;
};

LampTally CountLamps(const CaseOrder& order, std::size_t piece) {
  Episode episode(LampScene(PieceSeed(order, piece)), ModelsOf(TunnelTargets()), ImagingOf(piece));
  LampTally tally;
  for (std::size_t trigger = 0; trigger < kPieceFrames; ++trigger) {
    const auto& result = episode.Expose(trigger);
    ++tally.pairs;
    for (const auto& fix : result.fixes.targets) {
      if (fix.state.points.status == stereo::FixStatus::kLost) continue;
      ++tally.reported;
      std::ostringstream text;
      text << Label(order, piece) << " trigger " << trigger << ": "
           << TunnelTargets()[fix.state.points.target].name << " reported at "
           << fix.state.points.epicenter_b_m.transpose() << " m";
      if (tally.findings.empty()) tally.findings.push_back(text.str());
    }
  }
  tally.rendered = ImagingOf(piece) == Imaging::kRendered ? tally.pairs : 0;
  return tally;
}

sim::Scene MirrorScene(std::uint64_t seed) {
  Tunnel tunnel(seed, TunnelRig(9));
  const auto targets = TunnelTargets();
  for (const base::Target& target : targets) tunnel.AddTarget(target, RideOf(target));
  tunnel.AddLamps(10);
  tunnel.AddWater(tunnel.Draw().Uniform(0.3, 0.95), tunnel.Draw().Uniform(0, 0.0005));
  const double from_s = tunnel.Draw().Uniform(0.3, 0.6);
  const auto hidden = static_cast<std::size_t>(tunnel.Draw().Uniform(0, 3));
  // Plates before the LEDs hide none of their images: these are seen along other lines.
  if (tunnel.Draw().Uniform() < 0.3) tunnel.HideAll(hidden, {from_s, from_s + 0.3});
  return tunnel.Take();
}

}  // namespace

SuiteReport MeasureSwaps(const CaseOrder& order) {
  const TargetTally sum = CountPieces(order, "swaps", PiecesFor(order.CountOr(18'000)), SwapScene);
  SuiteReport report;
  report.how = HowMany(sum, "three targets among 20 to 200 lamps, a tenth collinear with LEDs");
  ReportWrong(sum, report);
  report.AtLeast("found with four clear LEDs", sum.four.Pct(), 99.9, "%", 3);
  report.AtLeast("found with three clear LEDs", sum.three.Pct(), 99, "%", 3);
  report.Inform("found with two clear LEDs, once locked", sum.two_locked.Pct(), "%", 3);
  report.Inform("lost for more than two pairs with four clear LEDs",
                static_cast<double>(sum.beyond_reacquisition), "", 0);
  report.findings = sum.findings;
  return report;
}

SuiteReport MeasureLamps(const CaseOrder& order) {
  const std::size_t pieces =
      std::max<std::size_t>(1, (order.CountOr(6'000) + kPieceFrames - 1) / kPieceFrames);
  const auto tallies =
      WorkInParallel<LampTally>("lamps", pieces, [&order](std::size_t i) { return CountLamps(order, i); });
  LampTally sum;
  for (const LampTally& tally : tallies) {
    sum.pairs += tally.pairs, sum.rendered += tally.rendered, sum.reported += tally.reported;
    sum.findings.insert(sum.findings.end(), tally.findings.begin(), tally.findings.end());
  }
  SuiteReport report;
  std::ostringstream how;
  how << sum.pairs << " pairs, " << sum.rendered
      << " of them rendered; lamps, rows of lamps, headlights, reflections";
  report.how = how.str();
  report.AtMost("positions reported", static_cast<double>(sum.reported), 0, "", 0);
  report.findings = sum.findings;
  return report;
}

SuiteReport MeasureMirror(const CaseOrder& order) {
  const TargetTally sum = CountPieces(order, "mirror", PiecesFor(order.CountOr(9'000)), MirrorScene);
  SuiteReport report;
  report.how =
      HowMany(sum, "three targets over water that mirrors them, hidden themselves for a while now and then");
  ReportWrong(sum, report);
  report.AtLeast("found with four clear LEDs", sum.four.Pct(), 99.9, "%", 3);
  report.findings = sum.findings;
  return report;
}

}  // namespace adit::host
