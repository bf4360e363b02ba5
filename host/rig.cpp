#include "host/rig.h"

#include <Eigen/Geometry>
#include <filesystem>
#include <iomanip>
#include <iostream>
#include <memory>
#include <sstream>
#include <vector>

#include "drivers/linux/atomic_file.h"
#include "firmware/base/yaml.h"
#include "firmware/optics/rig.h"
#include "host/failure.h"
#include "host/provenance.h"

namespace adit::host {
namespace {

constexpr double kRadPerMicro = 1e-6;
/// A larger turn is no correction: the images of bars do not show well enough where all of it belongs.
constexpr double kTurnMaxRad = 1e-3;

struct Arguments {
  std::string rig, out;
  std::vector<double> turn_urad, sigma_urad;
};

Eigen::Vector3d Radians(const std::vector<double>& urad) {
  return kRadPerMicro * Eigen::Vector3d(urad[0], urad[1], urad[2]);
}

int Correct(const Arguments& arguments) {
  // The calibration in use stays as it is: whoever is to go back to it finds it.
  std::error_code none;
  if (std::filesystem::equivalent(arguments.rig, arguments.out, none))
    return Fail("rig correct", {base::ErrorCode::kOutOfRange, "--out", "names the rig file itself"});
  const auto text =
      CorrectedRig(arguments.rig, {Radians(arguments.turn_urad), Radians(arguments.sigma_urad)});
  if (!text) return Fail("rig correct", text.error());
  if (auto written = linux::WriteFileAtomically(arguments.out, *text); !written)
    return Fail("rig correct", written.error());
  const auto rig = optics::LoadRig(arguments.out);
  if (!rig) return Fail("rig correct", rig.error());
  std::cout << arguments.out << ": calibration " << rig->calibration_id << "\n";
  return 0;
}

}  // namespace

base::Result<std::string> CorrectedRig(const std::string& path, const CameraTurn& turn) {
  const auto refusal = [](const char* option, const char* detail) {
    return base::Error{base::ErrorCode::kOutOfRange, option, detail};
  };
  if (!(turn.turn_rad.norm() <= kTurnMaxRad))
    return refusal("--turn-urad", "is more than 1000 urad; calibrate anew");
  if (!(turn.sigma_rad.minCoeff() > 0 && turn.sigma_rad.maxCoeff() <= kTurnMaxRad))
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
  const auto angles = [correct](const char* name, std::vector<double>& urad, const char* meaning) {
    correct->add_option(name, urad, meaning)->required()->expected(3)->delimiter(',');
  };
  angles("--turn-urad", arguments->turn_urad, "pitch,yaw,roll as reported");
  angles("--sigma-urad", arguments->sigma_urad, "their standard deviations");
  correct->add_option("--out", arguments->out, "the new rig file")->required();
  correct->callback([arguments, &exit_code] { exit_code = Correct(*arguments); });
}

}  // namespace adit::host
