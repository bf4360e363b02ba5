// The pages of evaluate, intrinsics and georef: that they say what their commands say.
#include <string>

#include "host/calibrate_report.h"
#include "host/evaluate_report.h"
#include "host/georef_page.h"
#include "host/intrinsics_report.h"
#include "host/simulated_calibration.h"
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

// Ten wrong pairs among 120 bars, and lenses that are not as their files say.
TEST(ReportHooks, CalibrateTellsItsFiguresAndWhereEveryBarWent) {
  adit::host::CalibrationPlan plan;
  plan.bars = 120;
  auto draw = adit::host::Draw(plan, 4);
  for (std::size_t i = 0; i < 10; ++i) draw.input.bars[i].right = draw.input.bars[i + 20].right;
  const auto calibration = *adit::host::Calibrate(draw.input);
  const ReportPage page = adit::host::MakeCalibrateReport(draw.input, calibration);

  CheckNumbers(page);
  const std::string json = page.Json();
  const std::size_t used = calibration.quality.bars_used, held = calibration.quality.hold_out.bars.size(),
                    wrong = calibration.wrong.size();
  LONGS_EQUAL(120, used + held + wrong);
  CHECK_COMPARE(wrong, >=, 10);
  const std::string counts = "\"bars_seen\": 120, \"bars_used\": " + std::to_string(used) +
                             ", \"bars_held_out\": " + std::to_string(held) +
                             ", \"wrong_pairs\": " + std::to_string(wrong) + ",";
  CHECK(Tells(json, counts));
  for (const char* camera : {"cam0", "cam1"}) {
    for (const char* name : {"fu", "fv", "cu", "cv", "k1"})
      STRCMP_CONTAINS(
          ("{\"camera\": \"" + std::string(camera) + "\", \"parameter\": \"" + name + "\", ").c_str(),
          json.c_str());
  }
  CHECK_FALSE(Tells(json, "\"parameter\": \"k2\""));
  for (const char* part : {"depth_mm_per_urad_yaw", "depth_mm_per_0_01_px", "Held-out bars against",
                           "From above", "\"reason\": \"off the epipolar lines\""})
    STRCMP_CONTAINS(part, json.c_str());
}

TEST(ReportHooks, CalibrateSaysThatExactLensesStayAsTheyAre) {
  adit::host::CalibrationPlan plan;
  plan.bars = 60;
  plan.intrinsics = {0, 0, 0};
  const auto draw = adit::host::Draw(plan, 5);
  const auto calibration = *adit::host::Calibrate(draw.input);
  const std::string json = adit::host::MakeCalibrateReport(draw.input, calibration).Json();
  STRCMP_CONTAINS("Taken as in their files.", json.c_str());
  CHECK_FALSE(Tells(json, "\"parameter\""));
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
