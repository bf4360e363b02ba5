#include "host/rig.h"

#include <Eigen/Geometry>
#include <iomanip>
#include <iostream>
#include <memory>
#include <sstream>
#include <vector>

#include "drivers/linux/atomic_file.h"
#include "firmware/base/yaml.h"
#include "firmware/optics/rig.h"
#include "firmware/publish/health_report.h"
#include "host/failure.h"
#include "host/provenance.h"

namespace adit::host {
namespace {

constexpr double kRadPerMicro = 1e-6;
/// A larger turn is no correction: the images of bars do not show well enough where all of it belongs.
constexpr double kTurnMaxRad = 1e-3;

struct Arguments {
  std::string rig, health, out;
  std::vector<double> turn_urad, sigma_urad;
};

template <class Angles>
Eigen::Vector3d Radians(const Angles& urad) {
  return kRadPerMicro * Eigen::Vector3d(urad[0], urad[1], urad[2]);
}

/// From the box's report, or as typed.
base::Result<CameraTurn> TurnOf(const Arguments& arguments) {
  if (arguments.health.empty())
    return CameraTurn{Radians(arguments.turn_urad), Radians(arguments.sigma_urad)};
  const auto rig = optics::LoadRig(arguments.rig);
  if (!rig) return rig.error();
  return LoadTurn(arguments.health, rig->calibration_id);
}

int Correct(const Arguments& arguments) {
  if (arguments.health.empty() && arguments.turn_urad.empty())
    return Fail("rig correct", {base::ErrorCode::kUsage, "--health",
                                "is missing; give the box's health report, or --turn-urad and --sigma-urad"});
  const auto turn = TurnOf(arguments);
  if (!turn) return Fail("rig correct", turn.error());
  const auto text = CorrectedRig(arguments.rig, *turn);
  if (!text) return Fail("rig correct", text.error());
  if (auto written = linux::WriteFileAtomically(arguments.out, *text); !written)
    return Fail("rig correct", written.error());
  const auto rig = optics::LoadRig(arguments.out);
  if (!rig) return Fail("rig correct", rig.error());
  std::cout << arguments.out << ": calibration " << rig->calibration_id << "\n";
  return 0;
}

}  // namespace

base::Result<CameraTurn> LoadTurn(const std::string& health_path, const std::string& calibration_id) {
  const auto report = publish::LoadHealthReport(health_path);
  if (!report) return report.error();
  const auto refusal = [&health_path](const char* key, const std::string& detail) {
    return base::Error{base::ErrorCode::kFailed, health_path + ": calibration" + key, detail};
  };
  if (!report->calibration) return refusal("", "is missing; this box does not watch its calibration");
  const publish::CalibrationHealth& found = *report->calibration;
  if (found.calibration_id != calibration_id)
    return refusal(".id", "is '" + found.calibration_id + "', the rig file's is '" + calibration_id +
                              "'; correct the file that the box uses");
  if (found.verdict != "changed")
    return refusal(".verdict", "is '" + found.verdict + "'; there is no turn to correct");
  return CameraTurn{Radians(found.turn_urad), Radians(found.sigma_urad)};
}

base::Result<std::string> CorrectedRig(const std::string& path, const CameraTurn& turn) {
  const auto refusal = [](const char* option, const char* detail) {
    return base::Error{base::ErrorCode::kOutOfRange, option, detail};
  };
  if (!(turn.turn_rad.norm() <= kTurnMaxRad))
    return refusal("--turn-urad", "is more than 1000 urad; calibrate anew");
  // Coefficient by coefficient: Eigen's minimum of a vector with a NaN may be any.
  if (!((turn.sigma_rad.array() > 0) && (turn.sigma_rad.array() <= kTurnMaxRad)).all())
    return refusal("--sigma-urad", "must be from above 0 to 1000 urad");
  auto rig = optics::LoadRig(path);
  if (!rig) return rig.error();
  auto covariance = optics::LoadRigCovariance(path);
  if (!covariance) return covariance.error();
  const double angle_rad = turn.turn_rad.norm();
  const Eigen::Matrix3d rotation =
      angle_rad > 0 ? Eigen::AngleAxisd(angle_rad, turn.turn_rad / angle_rad).toRotationMatrix()
                    : Eigen::Matrix3d(Eigen::Matrix3d::Identity());
  const std::string from = rig->calibration_id;
  rig->T_r_l.rotation = rotation * rig->T_r_l.rotation;
  rig->T_r_l.translation_m = rotation * rig->T_r_l.translation_m;
  rig->calibration_id.clear();
  rig->calibration_id = Crc32(optics::FormatRig(*rig));
  std::ostringstream text;
  text << optics::FormatRig(*rig);
  if (*covariance) {
    // The centre stays: with the turn w the translation moves by w x t.
    Eigen::Matrix<double, 6, 3> by_turn;
    by_turn << Eigen::Matrix3d::Identity(), -base::Skew(rig->T_r_l.translation_m);
    const Eigen::Matrix3d added = turn.sigma_rad.cwiseAbs2().asDiagonal();
    (*covariance)->topLeftCorner<6, 6>() += by_turn * added * by_turn.transpose();
    text << optics::FormatRigCovariance(**covariance);
  }
  text << "quality:\n  corrected_from: " << base::Quoted(from) << std::setprecision(9) << "\n  turn_rad: ["
       << turn.turn_rad.x() << ", " << turn.turn_rad.y() << ", " << turn.turn_rad.z() << "]\n";
  return text.str();
}

void AddRig(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("rig", "apply what the box has found out about its rig");
  command->require_subcommand(1);
  auto arguments = std::make_shared<Arguments>();
  CLI::App* correct =
      command->add_subcommand("correct", "a new calibration: the right camera turned as aditd reports it");
  correct->add_option("--rig", arguments->rig, "the calibration in use")->required();
  CLI::Option* health =
      correct->add_option("--health", arguments->health, "the box's health report, which states the turn");
  const auto angles = [correct, health](const char* name, std::vector<double>& urad, const char* meaning) {
    return correct->add_option(name, urad, meaning)->expected(3)->delimiter(',')->excludes(health);
  };
  CLI::Option* turn = angles("--turn-urad", arguments->turn_urad, "instead: pitch,yaw,roll as aditd says");
  CLI::Option* sigma = angles("--sigma-urad", arguments->sigma_urad, "their standard deviations");
  turn->needs(sigma);
  sigma->needs(turn);
  correct->add_option("--out", arguments->out, "the new rig file")->required();
  correct->callback([arguments, &exit_code] { exit_code = Correct(*arguments); });
}

}  // namespace adit::host
