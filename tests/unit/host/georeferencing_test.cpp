#include "host/georeferencing.h"

#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <fstream>

#include "host/georef_report.h"
#include "tests/unit/host/survey_truth.h"

#include <CppUTest/TestHarness.h>

namespace {

using adit::host::Adjust;
using adit::host::ControlFile;
using adit::host::ControlPoint;
using adit::host::Georeferencing;
using adit::host::GeorefOrigin;
using adit::host::MatchedPoint;
using adit::host::MatchOptions;
using adit::host::MatchPoints;
using adit::pipeline::TrackRow;
using adit::test::SurveyTruth;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kRadPerDeg = 3.14159265358979323846 / 180;

std::vector<MatchedPoint> Matched(unsigned seed) {
  std::vector<MatchedPoint> matches;
  for (const auto& point : SurveyTruth(seed, 0.0005).Measure()) {
    MatchedPoint match;
    match.common = point;
    match.rig_name = "bar." + std::to_string(matches.size() + 1);
    match.rows = 60;
    matches.push_back(match);
  }
  return matches;
}

ControlFile Control(const std::vector<std::string>& names) {
  ControlFile control{"p.csv", "12345678", {}};
  for (const std::string& name : names) {
    ControlPoint point;
    point.name = name;
    point.line = control.points.size() + 2;
    for (auto& coordinate : point.enh) coordinate.value_m = 10.0 * static_cast<double>(point.line);
    control.points.push_back(point);
  }
  return control;
}

std::vector<TrackRow> Track() {
  TrackRow row;
  row.target = "bar";
  row.status = adit::stereo::FixStatus::kTracked;
  row.position_m = {1, 2, 40};
  row.sigma_m = {0.001, 0.001, 0.001};
  return {row};
}

std::string MatchComplaint(const ControlFile& control, const MatchOptions& options = {}) {
  const auto matches = MatchPoints(control, Track(), options);
  return matches ? "" : matches.error().Line();
}

}  // namespace

TEST_GROUP(Georeferencing){};

TEST(Georeferencing, MatchesByNameAndByPair) {
  ControlFile control = Control({"bar", "bar.1", "473", "other"});
  control.points[1].sigma_m = 0.004;
  MatchOptions options;
  options.pairs = {{"473", "bar.4"}};
  options.excluded = {"bar.1"};
  const auto matches = *MatchPoints(control, Track(), options);
  LONGS_EQUAL(3, matches.size());
  STRCMP_EQUAL("bar.4", matches[2].rig_name.c_str());
  CHECK_FALSE(matches[1].used);
  CHECK((matches[0].common.control_s_m - Vector3d(20, 20, 20)).norm() == 0);
  DOUBLES_EQUAL(4e-6, matches[0].common.control_covariance_m2(0, 0), 1e-18);
  DOUBLES_EQUAL(16e-6, matches[1].common.control_covariance_m2(2, 2), 1e-18);
}

TEST(Georeferencing, NamesWhatDoesNotMatch) {
  MatchOptions options;
  STRCMP_CONTAINS("p.csv: names no target or LED of the track, which has bar",
                  MatchComplaint(Control({"a", "b"})).c_str());
  options.pairs = {{"473", "bus.4"}};
  STRCMP_CONTAINS("--pair 473=bus.4: is no point of p.csv",
                  MatchComplaint(Control({"bar"}), options).c_str());
  STRCMP_CONTAINS("--pair 473=bus.4: names no target", MatchComplaint(Control({"473"}), options).c_str());
  options = {};
  options.excluded = {"P9"};
  STRCMP_CONTAINS("--exclude P9: is no point", MatchComplaint(Control({"bar"}), options).c_str());
  options = {};
  options.pairs = {{"473", "bar"}};
  STRCMP_CONTAINS("both bar", MatchComplaint(Control({"bar", "473"}), options).c_str());
  STRCMP_CONTAINS("p.csv:3: point bar stands in line 2 too", MatchComplaint(Control({"bar", "bar"})).c_str());
}

TEST(Georeferencing, AMissingHeightMattersOnlyWhereItIsUsed) {
  ControlFile control = Control({"bar", "other"});
  control.points[1].enh[2].value_m.reset();
  STRCMP_EQUAL("", MatchComplaint(control).c_str());
  control.points[0].enh[2] = {std::nullopt, "83..10+00000000000-----"};
  STRCMP_CONTAINS("p.csv:2: point bar: word 83..10+00000000000----- has no value",
                  MatchComplaint(control).c_str());
}

TEST(Georeferencing, AcceptsASurveyAndTheBoxReadsItBack) {
  const SurveyTruth truth(7, 0.0005);
  const Georeferencing result = *Adjust(Matched(7), {}, {});
  CHECK_FALSE(result.Refusal().has_value());
  const char* const path = "georeferencing_test.tmp.yaml";
  const GeorefOrigin origin{"p.csv", "12345678", "t.csv", "cal1", "2024-01-01T00:00:00Z", "R. \"A\"", {}};
  std::ofstream(path) << FormatGeorefFile(result, origin);
  const auto loaded = adit::georef::LoadOrientation(path, "cal1");
  std::remove(path);
  if (!loaded) FAIL(loaded.error().Line().c_str());
  const Vector3d target_b_m(2, 0, 50);
  const Vector3d error_m = loaded->Apply(target_b_m) - truth.Place(target_b_m);
  const Matrix3d covariance = loaded->Propagate(target_b_m, Matrix3d::Zero());
  CHECK(error_m.norm() < 0.003);
  CHECK((error_m.array().abs() < 5 * covariance.diagonal().array().sqrt()).all());
}

TEST(Georeferencing, RefusesABlunderByNameUntilItIsExcluded) {
  auto points = Matched(8);
  points[1].common.control_s_m.y() += 0.02;
  const auto refusal = Adjust(points, {}, {})->Refusal();
  CHECK_TRUE(refusal.has_value());
  STRCMP_CONTAINS("point P2 is suspected of a blunder", refusal->c_str());
  STRCMP_CONTAINS("--exclude P2", refusal->c_str());
  points[1].used = false;
  const Georeferencing result = *Adjust(points, {}, {});
  CHECK_FALSE(result.Refusal().has_value());
  LONGS_EQUAL(4, result.used);
  STRCMP_EQUAL("P2", result.points[4].common.name.c_str());
  DOUBLES_EQUAL(0.02, result.fit.Residual(result.points[4].common).y(), 0.005);
}

TEST(Georeferencing, RefusesWhatExceedsALimit) {
  const Georeferencing result = *Adjust(Matched(9), {}, {.rms_m = 1e-5, .residual_m = 1});
  STRCMP_CONTAINS("fits the others worst", result.Refusal()->c_str());
  auto three = Matched(9);
  three.resize(3);
  three[0].common.control_s_m.x() += 1;
  STRCMP_CONTAINS("too few points to tell", Adjust(three, {}, {})->Refusal()->c_str());
}

TEST(Georeferencing, EstimatesTheScaleForInformation) {
  auto points = Matched(10);
  for (auto& point : points) point.common.rig_b_m *= 0.9999;
  const Georeferencing result = *Adjust(points, {}, {});
  DOUBLES_EQUAL(100, result.scale_ppm, 5 * result.scale_sigma_ppm);
  DOUBLES_EQUAL(1, result.fit.scale, 0);
  CHECK(result.scale_sigma_ppm < 50);
}

TEST(Georeferencing, WorseFitsThanToldMakeSigmasLarger) {
  auto points = Matched(11);
  for (auto& point : points) {
    point.common.control_covariance_m2 *= 1e-2;
    point.common.rig_covariance_m2 *= 1e-2;
  }
  const Georeferencing result = *Adjust(points, {}, {});
  CHECK(result.fit.sigma0 > 2);
  const auto covariance = result.Orientation("").covariance;
  DOUBLES_EQUAL(result.fit.sigma0 * result.fit.sigma0 * result.fit.covariance(4, 4), covariance(4, 4), 1e-15);
}

TEST_GROUP(GeorefReport){};

TEST(GeorefReport, AttitudeIsHeadingPitchAndRoll) {
  // FRAMES.md: level, azimuth 36.87 degrees.
  const Matrix3d frames = (Matrix3d() << 0.8, 0, 0.6, -0.6, 0, 0.8, 0, -1, 0).finished();
  CHECK((adit::host::AttitudeOf(frames) - Vector3d(std::atan2(0.6, 0.8), 0, 0)).norm() < 1e-12);
  for (const double heading_deg : {0.0, 90.0, 200.0, 359.0}) {
    for (const double pitch_deg : {-20.0, 0.0, 5.0}) {
      for (const double roll_deg : {-100.0, 0.0, 3.0}) {
        const Matrix3d turned =
            Eigen::AngleAxisd(-heading_deg * kRadPerDeg, Vector3d::UnitZ()).toRotationMatrix() *
            adit::host::LevelFrame(pitch_deg * kRadPerDeg, roll_deg * kRadPerDeg);
        const Vector3d attitude_deg = adit::host::AttitudeOf(turned) / kRadPerDeg;
        CHECK((attitude_deg - Vector3d(heading_deg, pitch_deg, roll_deg)).norm() < 1e-9 ||
              std::abs(attitude_deg.x() - 360) < 1e-9);
      }
    }
  }
}

TEST(GeorefReport, HoldsWhatASurveyorLooksFor) {
  auto points = Matched(8);
  points[1].common.control_s_m.y() += 0.02;
  const Georeferencing wrong = *Adjust(points, {}, {});
  GeorefOrigin origin{"p.csv", "12345678", "t.csv", "cal1", "2024-01-01T00:00:00Z", "R. A.", {}};
  const std::string refused = FormatGeorefReport(wrong, origin);
  for (const char* word :
       {"easting_m", "heading_deg", "sigma0", "redundancy 9", "scale_ppm", "left out", "blunder suspected",
        "critical (0.1 %): w 3.29, test 16.27", "rms", "crc32 12345678", "R. A.",
        "without P2 sigma0 would be", "verdict      refused", "control_m (E N H)"})
    STRCMP_CONTAINS(word, refused.c_str());
  points[1].used = false;
  origin.previous = wrong.Orientation("cal1");
  const std::string accepted = FormatGeorefReport(*Adjust(points, {}, {}), origin);
  STRCMP_CONTAINS("verdict      accepted", accepted.c_str());
  STRCMP_CONTAINS("not used", accepted.c_str());
  STRCMP_CONTAINS("against the georeference before", accepted.c_str());
}

TEST(GeorefReport, ItsSigmasAreThoseOfRandomSurveys) {
  constexpr unsigned kRuns = 400;
  Vector3d squares = Vector3d::Zero();
  for (unsigned run = 0; run < kRuns; ++run) {
    SurveyTruth truth(run);
    const auto fit = *FitHelmert(truth.Measure(), {});
    const Vector3d rig_b_m = Vector3d::Zero();
    const Eigen::Matrix<double, 3, 7> jacobian = fit.Jacobian(rig_b_m);
    const Matrix3d covariance = jacobian * fit.covariance * jacobian.transpose();
    const Vector3d error_m = fit.Apply(rig_b_m) - truth.Place(rig_b_m);
    squares += error_m.cwiseAbs2().cwiseQuotient(covariance.diagonal()) / kRuns;
  }
  std::printf("seeds 0 to %u: normalised squares %.2f %.2f %.2f ", kRuns - 1, squares.x(), squares.y(),
              squares.z());
  CHECK(((squares.array() - 1).abs() < 5 * std::sqrt(2.0 / kRuns)).all());
}
