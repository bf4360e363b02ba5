// The pages of evaluate, intrinsics and georef: that they say what their commands say.
#include <string>

#include "host/calibrate_report.h"
#include "host/evaluate_report.h"
#include "host/georef_page.h"
#include "host/intrinsics_report.h"
#include "host/seed_world.h"
#include "host/tunnel.h"
#include "tests/support/synthetic_board.h"
#include "tests/unit/host/survey_truth.h"

#include <CppUTest/TestHarness.h>

namespace {

using adit::host::ReportPage;
using Eigen::Vector3d;

bool Tells(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

/// Both forms of a page, neither with a number that is none.
void CheckNumbers(const ReportPage& page) {
  CHECK_FALSE(Tells(page.Html(), "nan"));
  CHECK_FALSE(Tells(page.Html(), "inf"));
  CHECK_FALSE(Tells(page.Json(), "nan"));
}

}  // namespace

TEST_GROUP(ReportHooks){};

TEST(ReportHooks, EvaluateShowsErrorsAndJudgesFalsePositions) {
  adit::host::Comparison comparison;
  adit::host::Figures figures;
  figures.target = "bar<a>", figures.to_m = 100, figures.visible = 200, figures.tracked = 200,
  figures.rms_m = 0.0031;
  comparison.figures.push_back(figures);
  for (int i = 0; i < 200; ++i)
    comparison.rows.push_back(
        {"bar<a>", {1, 0, 20.0 + i}, {0, 0, 0.003}, {0.001, 0.001, 0.002 + 1e-5 * i}, 0.001});

  const ReportPage good = MakeEvaluateReport(comparison, "track.csv", "truth.csv");
  CheckNumbers(good);
  STRCMP_CONTAINS("\"rms_mm\": 3.1", good.Json().c_str());
  STRCMP_CONTAINS("bar&lt;a&gt;", good.Html().c_str());
  STRCMP_CONTAINS("\"verdict\": \"good\"", good.Json().c_str());
  comparison.false_positions = 1;
  STRCMP_CONTAINS("\"verdict\": \"bad\"", MakeEvaluateReport(comparison, "t", "t").Json().c_str());
}

// A long track is thinned for the page; every target keeps its course.
TEST(ReportHooks, EvaluateThinsLongTracks) {
  adit::host::Comparison comparison;
  for (int i = 0; i < 20'000; ++i) comparison.rows.push_back({"bar", {0, 0, 20 + 0.001 * i}, {}, {}, 0});
  const std::string html = MakeEvaluateReport(comparison, "t", "t").Html();
  CHECK_COMPARE(html.size(), <, 600'000);
}

TEST(ReportHooks, IntrinsicsShowsParametersImagesAndCoverage) {
  std::mt19937_64 random(3);
  const auto calibration = *adit::host::CalibrateIntrinsics(
      adit::tests::SeenBoards(adit::tests::SyntheticBoard(), 10, 0.1, random), 640, 480);
  const ReportPage page = MakeIntrinsicsReport(calibration, *adit::host::ParseBoard("9x6", 0.04));
  CheckNumbers(page);
  STRCMP_CONTAINS("Where corners were measured", page.Html().c_str());
  STRCMP_CONTAINS("{\"name\": \"k1\", \"value\": ", page.Json().c_str());
  STRCMP_CONTAINS("times longer", page.Html().c_str());
}

// Eighty bars of an exact rig and ten wrong pairs among them.
TEST(ReportHooks, CalibrateLooksAtEveryBarAgain) {
  const auto rig = adit::host::TunnelRig(9);
  const adit::host::SeedSetup setup{9, 35, {"bar", {0, 0.25, 0.65, 1.5}, 0, 0.04}, 15, 30, 0, 0, 0.05};
  adit::host::SeedDraw draw(4, 1);
  std::vector<adit::host::StereoBar> bars;
  for (int i = 0; i < 90; ++i) {
    const auto pixels = *PixelsOf(rig, setup.bar, draw.Wave(rig, setup, 1));
    bars.push_back(adit::host::StereoBarOf(rig, draw.Noisy(pixels, 0.05), 0.05));
  }
  for (std::size_t i = 0; i < 10; ++i) bars[i].right = bars[i + 20].right;
  const std::vector<adit::base::Target> targets{setup.bar};

  const ReportPage page = adit::host::MakeCalibrateReport({"rec", rig, targets, bars, {}});

  CheckNumbers(page);
  STRCMP_CONTAINS("\"candidates\": 90, \"right\": 80", page.Json().c_str());
  STRCMP_CONTAINS("From above", page.Html().c_str());
}

TEST(ReportHooks, GeorefShowsPointsAndRefusals) {
  std::vector<adit::host::MatchedPoint> points;
  for (const auto& point : adit::test::SurveyTruth(5, 0.0005).Measure())
    points.push_back({point, "bar", 60, true});
  points.back().used = false;
  auto result = *adit::host::Adjust(points, {}, {});
  const adit::host::GeorefOrigin origin{"p&q.csv",     "12345678", "track.csv", "cal", "2024-05-06T07:08:09Z",
                                        "A. Surveyor", {}};
  const ReportPage page = MakeGeorefPage(result, origin);
  CheckNumbers(page);
  STRCMP_CONTAINS("p&amp;q.csv", page.Html().c_str());
  STRCMP_CONTAINS("not used", page.Html().c_str());
  STRCMP_CONTAINS("\"sigma0\": ", page.Json().c_str());
  result.limits.rms_m = 1e-9;
  STRCMP_CONTAINS("<b>refused: ", MakeGeorefPage(result, origin).Html().c_str());
}
