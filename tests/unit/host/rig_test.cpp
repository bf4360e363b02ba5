// adit rig correct: what it makes of a rig file, and what it refuses.
#include "host/rig.h"

#include <Eigen/Geometry>

#include "firmware/optics/rig.h"
#include "firmware/publish/health_report.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/synthetic_bar.h"

#include <CppUTest/TestHarness.h>

namespace {

using adit::host::CameraTurn;
using adit::host::CorrectedRig;
using adit::host::LoadTurn;
using adit::optics::RigCovariance;
using Eigen::Vector3d;

constexpr double kMicro = 1e-6;

/// A covariance with terms beside its diagonal.
RigCovariance SomeCovariance() {
  RigCovariance root = 1e-6 * RigCovariance::Identity();
  root(1, 3) = 2e-6, root(8, 0) = 1e-6;
  return root * root.transpose();
}

/// A turn small enough for differences, without the code under test.
Eigen::Matrix3d Turned(const Vector3d& turn_rad) {
  return Eigen::AngleAxisd(turn_rad.norm(), turn_rad.normalized()).toRotationMatrix();
}

}  // namespace

TEST_GROUP(RigCorrection) {
  adit::tests::ScratchFolder folder;
  adit::optics::Rig rig = adit::support::ToedInRig().AsRig();

  std::string WriteRig(bool with_covariance = true) {
    rig.calibration_id = "before";
    std::string text = adit::optics::FormatRig(rig);
    if (with_covariance) text += adit::optics::FormatRigCovariance(SomeCovariance());
    return folder.Write("rig.yaml", text);
  }
  adit::optics::Rig Corrected(const CameraTurn& turn) {
    const auto text = CorrectedRig(folder / "rig.yaml", turn);
    if (!text) FAIL(text.error().Line().c_str());
    const auto read = adit::optics::LoadRig(folder.Write("new.yaml", *text));
    if (!read) FAIL(read.error().Line().c_str());
    return *read;
  }
  void Refused(const char* where, const CameraTurn& turn) {
    const auto text = CorrectedRig(folder / "rig.yaml", turn);
    CHECK(!text);
    STRCMP_CONTAINS(where, text.error().Line().c_str());
  }
  void WriteHealth(const std::optional<adit::publish::CalibrationHealth>& calibration) {
    adit::publish::HealthReport report;
    report.written_ns = 1;
    report.state = "DEGRADED";
    report.counters = {{"pairs", 24'000}};
    report.latency = {{"locate", "pair -> result", 24'000, 0, 30, 60, 90, 200}};
    report.calibration = calibration;
    folder.Write("health.yaml", adit::publish::FormatHealthReport(report));
  }
  void RefusedReport(const char* part) {
    const auto turn = LoadTurn(folder / "health.yaml", "before");
    CHECK(!turn);
    STRCMP_CONTAINS("health.yaml", turn.error().Line().c_str());
    STRCMP_CONTAINS(part, turn.error().Line().c_str());
  }
};

TEST(RigCorrection, TurnsTheRightCameraAboutItsOwnCentre) {
  WriteRig();
  const Vector3d turn_rad = Vector3d(20, -300, 70) * kMicro;
  const auto corrected = Corrected({turn_rad, Vector3d::Constant(kMicro)});
  for (const Vector3d& point : {Vector3d(1, 2, 20), Vector3d(-3, 0.5, 80)}) {
    const Vector3d seen = Turned(turn_rad) * (rig.T_r_l * point);
    CHECK((corrected.T_r_l * point - seen).norm() < 1e-8 * point.norm());
  }
  CHECK((corrected.T_r_l.Inverse().translation_m - rig.T_r_l.Inverse().translation_m).norm() < 1e-9);
  CHECK(corrected.left.fu_px == rig.left.fu_px && corrected.right.k1 == rig.right.k1);
}

TEST(RigCorrection, IsANewCalibrationThatNamesTheOld) {
  WriteRig();
  const auto one = Corrected({{0, 10 * kMicro, 0}, Vector3d::Constant(kMicro)});
  CHECK(one.calibration_id != "before");
  CHECK(!one.calibration_id.empty());
  STRCMP_CONTAINS("corrected_from: \"before\"", adit::tests::ReadAll(folder / "new.yaml").c_str());
  const auto other = Corrected({{0, 11 * kMicro, 0}, Vector3d::Constant(kMicro)});
  CHECK(one.calibration_id != other.calibration_id);
}

TEST(RigCorrection, AddsTheTurnsUncertaintyToThatOfThePose) {
  WriteRig();
  const Vector3d turn_rad = Vector3d(0, 50, 0) * kMicro, sigma_rad = Vector3d(1, 4, 2) * kMicro;
  const auto corrected = Corrected({turn_rad, sigma_rad});
  const auto covariance = adit::optics::LoadRigCovariance(folder / "new.yaml");
  CHECK(covariance && *covariance);
  RigCovariance expected = SomeCovariance();
  for (int axis = 0; axis < 3; ++axis) {
    // One sigma more about this axis: where the translation goes.
    const Vector3d step = sigma_rad[axis] * Vector3d::Unit(axis);
    Eigen::Matrix<double, 6, 1> moved;
    moved << step, Turned(step) * corrected.T_r_l.translation_m - corrected.T_r_l.translation_m;
    expected.topLeftCorner<6, 6>() += moved * moved.transpose();
  }
  CHECK((**covariance - expected).cwiseAbs().maxCoeff() < 1e-4 * expected.cwiseAbs().maxCoeff());
}

TEST(RigCorrection, ARigWithoutCovarianceStaysWithout) {
  WriteRig(false);
  Corrected({{0, 10 * kMicro, 0}, Vector3d::Constant(kMicro)});
  const auto covariance = adit::optics::LoadRigCovariance(folder / "new.yaml");
  CHECK(covariance && !*covariance);
}

TEST(RigCorrection, RefusesWhatIsNoCorrection) {
  WriteRig();
  const Vector3d sigma_rad = Vector3d::Constant(kMicro);
  Refused("--turn-urad", {{0, 1001 * kMicro, 0}, sigma_rad});
  Refused("--turn-urad", {{0, std::nan(""), 0}, sigma_rad});
  Refused("--sigma-urad", {{0, 10 * kMicro, 0}, {kMicro, 0, kMicro}});
  Refused("--sigma-urad", {{0, 10 * kMicro, 0}, {kMicro, std::nan(""), kMicro}});
  folder.Write("rig.yaml", "name: loader\n");
  Refused("rig.yaml", {{0, 10 * kMicro, 0}, sigma_rad});
}

TEST(RigCorrection, TakesTheTurnFromTheBoxsReport) {
  WriteHealth({{"before", "changed", 400, {1, -12, 3}, {0.5, 1.5, 0.75}}});
  const auto turn = LoadTurn(folder / "health.yaml", "before");
  CHECK(!!turn);
  CHECK((turn->turn_rad - kMicro * Vector3d(1, -12, 3)).norm() < 0.01 * kMicro);
  CHECK((turn->sigma_rad - kMicro * Vector3d(0.5, 1.5, 0.75)).norm() < 0.01 * kMicro);
}

TEST(RigCorrection, RefusesAReportThatStatesNoTurnOfThisRig) {
  RefusedReport("cannot be");  // there is none
  WriteHealth(std::nullopt);
  RefusedReport("does not watch");
  WriteHealth({{"before", "holds", 400, {1, 2, 3}, {1, 1, 1}}});
  RefusedReport("'holds'");
  WriteHealth({{"before", "learning", 4, {}, {}}});
  RefusedReport("'learning'");
  WriteHealth({{"another", "changed", 400, {1, -12, 3}, {0.5, 1.5, 0.75}}});
  RefusedReport("'another'");
}
