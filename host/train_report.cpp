#include "host/train_report.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "firmware/identify/p2_invariant.h"
#include "host/confusion.h"

namespace adit::host {
namespace {

constexpr int kDistanceClasses = 12;
constexpr std::size_t kHitsMin = 10;  // a class with fewer says nothing of its ranges
constexpr double kDoubtShare = 0.1;   // of the images: fewer are dirt and hidden LEDs
constexpr std::size_t kProblemsShown = 200;
constexpr int kMapColumns = 8, kMapRows = 6, kCurvePoints = 60;

std::string Short(double value, int digits = 3) {
  std::ostringstream text;
  text.precision(digits);
  text << value;
  return text.str();
}

std::string SideName(base::Side side) { return side == base::Side::kLeft ? "cam0" : "cam1"; }

/// The hits that count: of images with exactly one.
std::vector<const TrainingHit*> GoodHits(const Training& training, std::optional<base::Side> side = {}) {
  std::vector<const TrainingHit*> good;
  for (const TrainingImage& image : training.images) {
    if (side && image.side != *side) continue;
    std::vector<const TrainingHit*> passing;
    for (const TrainingHit& hit : image.hits) {
      if (Passes(training.model, hit)) passing.push_back(&hit);
    }
    if (passing.size() == 1) good.push_back(passing[0]);
  }
  return good;
}

double ApparentM(const Training& training, const TrainingHit& hit) {
  return training.options.focal_px * training.model.target.LengthM() / hit.figures.length_px;
}

PlotSeries Level(const std::string& name, PlotMark mark, double value, const TrainingOptions& options) {
  return {name, mark, {{options.nearest_m, value}, {options.farthest_m, value}}, {}};
}

/// p2 and what noise makes of it, seen across the view.
std::pair<PlotSeries, PlotSeries> NoiseCurves(const Training& training) {
  const TrainingOptions& o = training.options;
  const base::Target& target = training.model.target;
  PlotSeries low{"what 4.5 sigmas of noise make of it", PlotMark::kDottedLine, {}, {}},
      high{"", PlotMark::kDottedLine, {}, {}};
  const double ratio = identify::CrossRatio(target.leds_m);
  double slopes2 = 0;
  for (const double slope : identify::CrossRatioSlopes(target.leds_m)) slopes2 += slope * slope;
  for (int i = 0; i <= kCurvePoints; ++i) {
    const double distance_m =
        o.nearest_m * std::pow(o.farthest_m / o.nearest_m, double{1} * i / kCurvePoints);
    const double reach = 4.5 * o.noise_px * std::sqrt(slopes2) * distance_m / o.focal_px;
    const double a = identify::P2(ratio - reach), b = identify::P2(std::min(0.5, ratio + reach));
    low.points.emplace_back(distance_m, std::min(a, b));
    high.points.emplace_back(distance_m, std::max(a, b));
  }
  return {low, high};
}

Plot P2Plot(const Training& training) {
  Plot plot{"p2 invariant against distance",
            "Every point one image with one hit.",
            {"apparent distance, m", true, false, {}},
            {"p2", false, false, {}},
            false,
            {},
            {},
            {},
            {}};
  PlotSeries measured{"measured", PlotMark::kDot, {}, {}};
  for (const TrainingHit* hit : GoodHits(training))
    measured.points.emplace_back(ApparentM(training, *hit), hit->figures.p2);
  PlotSeries wrong{"second match or missed", PlotMark::kCross, {}, {}};
  for (const ImageProblem& problem : training.review.problems)
    wrong.points.emplace_back(ApparentM(training, problem.hit), problem.hit.figures.p2);
  const auto [low, high] = NoiseCurves(training);
  plot.series = {measured,
                 wrong,
                 low,
                 high,
                 Level("trained range", PlotMark::kDashedLine, training.model.p2_min, training.options),
                 Level("", PlotMark::kDashedLine, training.model.p2_max, training.options)};
  return plot;
}

Plot LinePlot(const Training& training) {
  Plot plot{"Distance of the LEDs from their line",
            "Rms of the four. What noise explains ends at the dashed line.",
            {"apparent distance, m", true, false, {}},
            {"rms, px", false, false, {}},
            false,
            {},
            {},
            {},
            {}};
  PlotSeries measured{"measured", PlotMark::kRing, {}, {}};
  for (const TrainingHit* hit : GoodHits(training))
    measured.points.emplace_back(ApparentM(training, *hit),
                                 hit->figures.collinearity * hit->figures.length_px);
  plot.series = {measured, Level("what noise explains", PlotMark::kDashedLine,
                                 training.review.collinearity_limit_px, training.options)};
  return plot;
}

Plot DistancePlot(const Training& training) {
  Plot plot{"Hits by distance",
            "Classes of equal ratio; at least ten hits are wanted in each.",
            {"apparent distance, m", true, false, {}},
            {"hits", false, false, {}},
            false,
            {},
            {},
            {},
            {}};
  PlotSeries steps{"hits", PlotMark::kLine, {}, {}};
  double most = 0;
  for (const DistanceClass& c : DistanceClasses(training)) {
    const auto hits = static_cast<double>(c.hits);
    steps.points.insert(steps.points.end(), {{c.from_m, hits}, {c.to_m, hits}});
    most = std::max(most, hits);
  }
  plot.series = {steps, Level("ten", PlotMark::kDottedLine, static_cast<double>(kHitsMin), training.options)};
  plot.y.range = {0, std::max(1.1 * most, 12.0)};
  return plot;
}

Plot MapPlot(const Training& training, base::Side side) {
  const Eigen::Vector2d size = training.size_px.cast<double>();
  Plot plot{"LEDs in the image of " + SideName(side),
            "Counts of LEDs in 8 x 6 cells; hatched: none.",
            {"u, px", false, false, std::pair{0.0, size.x()}},
            {"v, px", false, true, std::pair{0.0, size.y()}},
            true,
            {},
            {},
            {},
            {}};
  PlotCells cells{"LEDs", kMapColumns, kMapRows, std::vector<double>(kMapColumns * kMapRows, 0),
                  {0, 0}, size};
  for (const TrainingHit* hit : GoodHits(training, side)) {
    for (const Eigen::Vector2d& led : hit->leds_px) {
      const int column = std::clamp(static_cast<int>(led.x() / size.x() * kMapColumns), 0, kMapColumns - 1);
      const int row = std::clamp(static_cast<int>(led.y() / size.y() * kMapRows), 0, kMapRows - 1);
      ++cells.values[static_cast<std::size_t>(row * kMapColumns + column)];
    }
  }
  plot.cells.push_back(cells);
  return plot;
}

ReportTable RangeTable(const Training& training) {
  ReportTable table{"ranges",
                    "What the identification may accept",
                    {{"value", "value"},
                     {"noise_min", "noise alone, from"},
                     {"noise_max", "to"},
                     {"measured_min", "measured, from"},
                     {"measured_max", "to"},
                     {"trained_min", "trained, from"},
                     {"trained_max", "to"}},
                    {}};
  const identify::Model noise = NoiseRanges(training.model.target, training.options);
  const auto good = GoodHits(training);
  const auto measured = [&](double TrainingSample::*figure, bool largest) {
    double value = std::nan("");
    for (const TrainingHit* hit : good)
      value = largest ? std::fmax(value, hit->figures.*figure) : std::fmin(value, hit->figures.*figure);
    return value;
  };
  const auto row = [&](const char* name, int decimals, double TrainingSample::*figure,
                       const std::array<double, 4>& limits) {
    const auto number = [decimals](double value) { return ReportNumber(value, decimals); };
    table.rows.push_back({ReportWords(name), number(limits[0]), number(limits[1]),
                          number(measured(figure, false)), number(measured(figure, true)), number(limits[2]),
                          number(limits[3])});
  };
  const identify::Model& model = training.model;
  row("p2", 4, &TrainingSample::p2, {noise.p2_min, noise.p2_max, model.p2_min, model.p2_max});
  row("collinearity (rms off the line / length)", 5, &TrainingSample::collinearity,
      {0, noise.collinearity_max, 0, model.collinearity_max});
  row("length, px", 1, &TrainingSample::length_px,
      {noise.length_min_px, noise.length_max_px, model.length_min_px, model.length_max_px});
  return table;
}

ReportTable ProblemTable(const Training& training) {
  ReportTable table{"problems",
                    "Images to look at, and what would mend each",
                    {{"recording", "recording"},
                     {"camera", "camera"},
                     {"timestamp_ns", "time, ns"},
                     {"finding", "finding"},
                     {"proposal", "proposal"}},
                    {}};
  for (const ImageProblem& problem : training.review.problems) {
    if (table.rows.size() == kProblemsShown) break;
    const TrainingImage& image = training.images[problem.image];
    table.rows.push_back({ReportWords(training.recordings[image.recording]),
                          ReportWords(SideName(image.side)),
                          ReportWords(std::to_string(image.mid_exposure_ns)), ReportWords(problem.finding),
                          ReportWords(problem.proposal)});
  }
  return table;
}

void AddOthers(const Training& training, ReportPage& page) {
  const ViewConditions view{training.options.tilt_max_rad, training.options.focal_px,
                            training.options.noise_px};
  const TrainingOptions& o = training.options;
  ReportTable table{"others",
                    "Targets that must not be taken for this one",
                    {{"target", "target"},
                     {"p2_min", "its p2, from"},
                     {"p2_max", "to"},
                     {"ranges", "p2 ranges"},
                     {"distinct_up_to_m", "distinct in one image up to, m"}},
                    {}};
  Plot plot{"How far apart the targets' images are",
            "Least over all leans; below the dashed line one can pass for the other in one image, and the "
            "pair must decide.",
            {"distance, m", true, false, {}},
            {"separation, sigmas of a centroid", true, false, {}},
            false,
            {},
            {},
            {},
            {}};
  PlotMark mark = PlotMark::kLine;
  for (const OtherTarget& other : training.others) {
    const bool overlap =
        other.model.p2_min <= training.model.p2_max && training.model.p2_min <= other.model.p2_max;
    table.rows.push_back({ReportWords(other.model.target.name), ReportNumber(other.model.p2_min, 4),
                          ReportNumber(other.model.p2_max, 4), ReportWords(overlap ? "overlap" : "apart"),
                          ReportNumber(other.distinct_up_to_m.value_or(0), 1)});
    PlotSeries series{other.model.target.name, mark, {}, {}};
    for (int i = 0; i <= kCurvePoints; ++i) {
      const double distance_m =
          o.nearest_m * std::pow(o.farthest_m / o.nearest_m, double{1} * i / kCurvePoints);
      series.points.emplace_back(
          distance_m,
          std::max(0.1, SeparationSigmas(training.model.target, other.model.target, distance_m, view)));
    }
    plot.series.push_back(series);
    mark = mark == PlotMark::kLine ? PlotMark::kDottedLine : PlotMark::kLine;
  }
  plot.series.push_back(Level("needed", PlotMark::kDashedLine, NeededSigmas(o.noise_px), o));
  page.Section("Other targets");
  page.Add(table);
  page.Add(plot);
}

}  // namespace

std::vector<DistanceClass> DistanceClasses(const Training& training) {
  const TrainingOptions& o = training.options;
  const double ratio = std::pow(o.farthest_m / o.nearest_m, 1.0 / kDistanceClasses);
  std::vector<DistanceClass> classes;
  for (int i = 0; i < kDistanceClasses; ++i)
    classes.push_back({o.nearest_m * std::pow(ratio, i), o.nearest_m * std::pow(ratio, i + 1), 0});
  for (const TrainingHit* hit : GoodHits(training)) {
    const double place = std::log(ApparentM(training, *hit) / o.nearest_m) / std::log(ratio);
    ++classes[static_cast<std::size_t>(std::clamp(static_cast<int>(place), 0, kDistanceClasses - 1))].hits;
  }
  return classes;
}

std::vector<std::string> UncoveredDistances(const Training& training) {
  std::vector<std::string> stretches;
  if (training.recordings.empty()) return stretches;
  const auto classes = DistanceClasses(training);
  for (std::size_t i = 0; i < classes.size(); ++i) {
    if (classes[i].hits >= kHitsMin) continue;
    const std::size_t first = i;
    while (i + 1 < classes.size() && classes[i + 1].hits < kHitsMin) ++i;
    stretches.push_back(Short(classes[first].from_m) + " to " + Short(classes[i].to_m) + " m");
  }
  return stretches;
}

std::string GeometryDoubt(const Training& training) {
  std::vector<double> p2;
  for (const ImageProblem& problem : training.review.problems) {
    if (problem.kind == ProblemKind::kMissed && !problem.hit.within_noise)
      p2.push_back(problem.hit.figures.p2);
  }
  if (static_cast<double>(p2.size()) <= kDoubtShare * static_cast<double>(training.images.size())) return "";
  const auto middle = p2.begin() + static_cast<std::ptrdiff_t>(p2.size() / 2);
  std::nth_element(p2.begin(), middle, p2.end());
  return std::to_string(p2.size()) +
         " images show a bar in the target's place that is not quite the target (p2 " + Short(*middle, 5) +
         ", as built " + Short(identify::P2(identify::CrossRatio(training.model.target.leds_m)), 5) +
         "): measure leds_m again";
}

std::vector<std::string> TrainingWarnings(const Training& training) {
  std::vector<std::string> warnings;
  if (training.recordings.empty())
    warnings.emplace_back("from geometry alone: no recording confirms the ranges");
  for (const std::string& stretch : UncoveredDistances(training))
    warnings.push_back("the recordings hardly show the target (held across the view) at " + stretch);
  if (!training.review.problems.empty())
    warnings.push_back(std::to_string(training.review.problems.size()) +
                       " images are problematic; each has a proposal");
  const std::string doubt = training.doubt.empty() ? GeometryDoubt(training) : training.doubt;
  if (!doubt.empty()) warnings.push_back(doubt);
  const double farthest_m = training.options.farthest_m;
  for (const OtherTarget& other : training.others) {
    if (other.distinct_up_to_m && *other.distinct_up_to_m >= farthest_m) continue;
    warnings.push_back("can be confused with '" + other.model.target.name + "' in one image " +
                       (other.distinct_up_to_m ? "beyond " + Short(*other.distinct_up_to_m) + " m"
                                               : std::string("at any distance")));
  }
  return warnings;
}

ReportPage MakeTrainReport(const Training& training) {
  const base::Target& target = training.model.target;
  std::string origin = training.recordings.empty() ? "from geometry" : "from";
  for (const std::string& recording : training.recordings) origin += " " + recording;
  ReportPage page("train", "Model of target '" + target.name + "'", origin);
  const auto warnings = TrainingWarnings(training);
  page.Verdict(warnings.empty() ? ReportVerdict::kGood : ReportVerdict::kCaution,
               warnings.empty() ? "The model is good." : "The model is usable, but:", warnings);
  const TrainingReview& review = training.review;
  const auto count = [](std::size_t n) { return ReportNumber(static_cast<double>(n), 0); };
  page.Facts(
      {{"led_2_m", "LED 2 along the bar", ReportNumber(target.leds_m[1], 4), "m"},
       {"led_3_m", "LED 3", ReportNumber(target.leds_m[2], 4), "m"},
       {"led_4_m", "LED 4 (length)", ReportNumber(target.leds_m[3], 4), "m"},
       {"p2_nominal", "p2 as built", ReportNumber(identify::P2(identify::CrossRatio(target.leds_m)), 4), ""},
       {"nearest_m", "intended from", ReportNumber(training.options.nearest_m, 1), "m"},
       {"farthest_m", "to", ReportNumber(training.options.farthest_m, 1), "m"},
       {"noise_px", "centroid noise assumed", ReportNumber(training.options.noise_px, 3), "px"},
       {"noise_seen_px", "seen (off the line)", ReportNumber(review.noise_px, 3), "px"},
       {"images", "images", count(training.images.size()), ""},
       {"one", "with one hit", count(review.one), ""},
       {"several", "with several", count(review.several), ""},
       {"none", "with none", count(review.none), ""},
       {"absent", "of these nothing like it", count(review.absent), ""}});
  page.Section("Trained ranges");
  page.Add(RangeTable(training));
  if (!training.images.empty()) {
    page.Add(P2Plot(training));
    page.Add(LinePlot(training));
    page.Section("What the recordings cover");
    page.Add(DistancePlot(training));
    page.Add(MapPlot(training, base::Side::kLeft));
    page.Add(MapPlot(training, base::Side::kRight));
  }
  if (!review.problems.empty() || !training.applied.empty()) page.Section("Problem images");
  for (const std::string& applied : training.applied) page.Paragraph("Done: " + applied);
  if (!review.problems.empty()) page.Add(ProblemTable(training));
  if (!training.others.empty()) AddOthers(training, page);
  return page;
}

}  // namespace adit::host
