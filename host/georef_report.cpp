#include "host/georef_report.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

#include "firmware/base/yaml.h"

namespace adit::host {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kDegPerRad = 180 / 3.14159265358979323846;
constexpr double kDifferenceRad = 1e-6;  // small against a circle, large against rounding

Matrix3d Turned(const Matrix3d& rotation, const Vector3d& turn_rad) {
  const double angle_rad = turn_rad.norm();
  return angle_rad > 0 ? Matrix3d(Eigen::AngleAxisd(angle_rad, turn_rad / angle_rad) * rotation) : rotation;
}

class ReportWriter {
 public:
  ReportWriter(const Georeferencing& result, const GeorefOrigin& origin) : result_(result), origin_(origin) {
    text_ << std::fixed;
  }

  std::string Write() {
    WriteOrigin();
    WriteParameters();
    WriteFitness();
    WritePoints();
    WriteTests();
    WriteVerdict();
    return text_.str();
  }

 private:
  void WriteOrigin() {
    const HelmertOptions& options = result_.options;
    text_ << "Georeference of the rig from control points\n\n"
          << "control      " << origin_.control_file << " (crc32 " << origin_.control_crc32 << ")\n"
          << "measured     " << origin_.measured << ", until " << origin_.time << "\n"
          << "rig          calibration " << origin_.calibration_id << "\n"
          << "surveyor     " << (origin_.surveyor.empty() ? "not told" : origin_.surveyor) << "\n"
          << "parameters   " << options.Parameters() << ": translation, heading"
          << (options.estimate_tilt ? ", tilt" : "") << (options.estimate_scale ? ", scale" : "")
          << "; grid scale factor " << std::setprecision(8) << options.grid_scale_factor << " (given)\n"
          << "points       " << result_.used << " used of " << result_.points.size() << " compared\n";
    if (!origin_.unmatched.empty()) text_ << "             " << UnmatchedText(origin_.unmatched) << "\n";
    text_ << "\n";
  }

  void Parameter(const char* name, int decimals, double value, double sigma) {
    text_ << std::left << std::setw(13) << name << std::right << std::setprecision(decimals) << std::setw(18)
          << value << std::setw(13) << sigma << "\n";
  }

  void WriteParameters() {
    const Vector3d place_m = result_.fit.Apply(Vector3d::Zero()), place_sigma_m = OriginSigma(result_);
    const Vector3d attitude_deg = AttitudeOf(result_.fit.R_s_b) * kDegPerRad;
    const Vector3d attitude_sigma_deg = AttitudeSigma(result_) * kDegPerRad;
    text_ << "parameter                 value        sigma   (sigma times " << std::setprecision(2)
          << result_.SigmaFactor() << ": sigma0 where above 1)\n";
    const char* const places[] = {"easting_m", "northing_m", "height_m"};
    const char* const angles[] = {"heading_deg", "pitch_deg", "roll_deg"};
    for (Eigen::Index i = 0; i < 3; ++i) Parameter(places[i], 4, place_m[i], place_sigma_m[i]);
    for (Eigen::Index i = 0; i < 3; ++i) {
      const bool is_given = i > 0 && !result_.options.estimate_tilt;
      Parameter(angles[i], 5, attitude_deg[i], is_given ? 0 : attitude_sigma_deg[i]);
    }
    Parameter("scale_ppm", 1, result_.scale_ppm, result_.SigmaFactor() * result_.scale_sigma_ppm);
    text_ << "  easting, northing, height: the projection centre of cam0; scale: beside the grid's, "
          << (result_.options.estimate_scale ? "applied" : "estimated for information, not applied") << "\n";
    if (origin_.previous) WriteDifference(*origin_.previous);
    text_ << "\n";
  }

  void WriteDifference(const georef::AbsoluteOrientation& previous) {
    const Vector3d moved_m =
        result_.fit.Apply(result_.fit.reference_b_m) - previous.Apply(result_.fit.reference_b_m);
    const double turned_rad =
        Eigen::AngleAxisd(Matrix3d(result_.fit.R_s_b * previous.T_s_b.rotation.transpose())).angle();
    text_ << std::setprecision(1) << "  against the georeference before: amid the points E "
          << moved_m.x() * 1e3 << ", N " << moved_m.y() * 1e3 << ", H " << moved_m.z() * 1e3 << " mm, turned "
          << turned_rad * 1e3 << " mrad\n";
  }

  void WriteFitness() {
    const Snooping& snooping = result_.snooping;
    text_ << std::setprecision(3) << "sigma0       " << result_.fit.sigma0 << " a posteriori (critical "
          << snooping.sigma0_critical << " at 5 %), redundancy " << result_.fit.redundancy << "\n";
    if (result_.fit.redundancy > 0 && result_.fit.sigma0 > snooping.sigma0_critical)
      text_ << "             the points fit worse than their sigmas say\n";
    text_ << std::setprecision(1) << "rms          horizontal " << result_.rms_horizontal_m * 1e3
          << ", vertical " << result_.rms_vertical_m * 1e3 << ", 3D " << result_.rms_m * 1e3 << " mm\n\n";
  }

  void WriteVector(const Vector3d& values, int width, int decimals) {
    text_ << std::setprecision(decimals);
    for (const double value : values) text_ << std::setw(width) << value;
  }

  void WritePoints() {
    text_ << "point            measured as       rows      control_m (E N H)                      residual_mm"
             " (E N H, 3D; control minus rig)\n";
    for (const MatchedPoint& point : result_.points) {
      const Vector3d residual_mm = 1e3 * result_.fit.Residual(point.common);
      text_ << std::left << std::setw(17) << point.common.name << std::setw(17) << point.rig_name
            << std::right << std::setw(5) << point.rows;
      WriteVector(point.common.control_s_m, 14, 4);
      WriteVector(residual_mm, 9, 1);
      text_ << std::setw(9) << residual_mm.norm() << (point.used ? "" : "  not used") << "\n";
    }
    text_ << "\n";
  }

  void WriteTests() {
    const Snooping& snooping = result_.snooping;
    text_ << "point             w (E N H)                redundancy          left out: residual_mm (E N H)"
             "      test\n";
    for (std::size_t i = 0; i < result_.used; ++i) {
      const PointTest& test = snooping.tests[i];
      text_ << std::left << std::setw(15) << result_.points[i].common.name << std::right;
      WriteVector(test.w, 8, 2);
      WriteVector(test.redundancy, 7, 2);
      if (test.left_out_m) {
        WriteVector(*test.left_out_m * 1e3, 11, 1);
        text_ << std::setw(10) << test.left_out_test;
      } else {
        text_ << "      the others alone determine no fit";
      }
      text_ << (snooping.suspects_blunder && i == *snooping.worst ? "  blunder suspected" : "") << "\n";
    }
    text_ << std::setprecision(2) << "critical (0.1 %): w " << snooping.w_critical << ", test "
          << snooping.left_out_critical << "\n";
    if (snooping.suspects_blunder) {
      text_ << "without " << result_.points[*snooping.worst].common.name << " sigma0 would be "
            << std::setprecision(3) << snooping.sigma0_without_worst << "\n";
    }
    if (!snooping.worst) text_ << "no point can be left out: a blunder would show, but not where\n";
    text_ << "\n";
  }

  void WriteVerdict() {
    const auto refusal = result_.Refusal();
    text_ << std::setprecision(1) << "limits       rms 3D " << result_.limits.rms_m * 1e3
          << " mm, single point " << result_.limits.residual_m * 1e3 << " mm\nverdict      "
          << (refusal ? *refusal : "accepted") << "\n";
  }

  const Georeferencing& result_;
  const GeorefOrigin& origin_;
  std::ostringstream text_;
};

}  // namespace

Vector3d AttitudeSigma(const Georeferencing& result) {
  Matrix3d jacobian;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const Vector3d turn_rad = kDifferenceRad * Vector3d::Unit(axis);
    const Vector3d difference_rad =
        AttitudeOf(Turned(result.fit.R_s_b, turn_rad)) - AttitudeOf(Turned(result.fit.R_s_b, -turn_rad));
    for (Eigen::Index i = 0; i < 3; ++i)  // heading and roll may step by a turn between the two
      jacobian(i, axis) = std::remainder(difference_rad[i], 2 * std::acos(-1.0)) / (2 * kDifferenceRad);
  }
  const Matrix3d covariance = jacobian * result.fit.covariance.topLeftCorner<3, 3>() * jacobian.transpose();
  return result.SigmaFactor() * covariance.diagonal().cwiseMax(0).cwiseSqrt();
}

Vector3d OriginSigma(const Georeferencing& result) {
  const Eigen::Matrix<double, 3, 7> jacobian = result.fit.Jacobian(Vector3d::Zero());
  const Matrix3d covariance = jacobian * result.fit.covariance * jacobian.transpose();
  return result.SigmaFactor() * covariance.diagonal().cwiseMax(0).cwiseSqrt();
}

Vector3d AttitudeOf(const Matrix3d& R_s_b) {
  const Vector3d right = R_s_b.col(0), down = R_s_b.col(1), forward = R_s_b.col(2);
  double heading_rad = std::atan2(forward.x(), forward.y());
  if (heading_rad < 0) heading_rad += 2 * std::acos(-1.0);
  return {heading_rad, std::atan2(forward.z(), forward.head<2>().norm()), std::atan2(-right.z(), -down.z())};
}

Matrix3d LevelFrame(double pitch_rad, double roll_rad) {
  const Matrix3d tilt =
      (Eigen::AngleAxisd(pitch_rad, Vector3d::UnitX()) * Eigen::AngleAxisd(roll_rad, Vector3d::UnitY()))
          .toRotationMatrix();
  return tilt * HelmertOptions{}.R_level_b;
}

std::string UnmatchedText(const std::vector<std::string>& names) {
  constexpr std::size_t kShown = 8;
  std::string text = std::to_string(names.size()) + " more in the control file, not in the track: ";
  for (std::size_t i = 0; i < std::min(kShown, names.size()); ++i) text += (i > 0 ? ", " : "") + names[i];
  return text + (names.size() > kShown ? " ..." : "");
}

std::string FormatGeorefReport(const Georeferencing& result, const GeorefOrigin& origin) {
  return ReportWriter(result, origin).Write();
}

std::string FormatGeorefFile(const Georeferencing& result, const GeorefOrigin& origin) {
  std::ostringstream text;
  text << "# The rig in the site grid: p_s = t + scale * diag(k, k, 1) R p_b, k the grid scale factor.\n"
       << georef::FormatOrientation(result.Orientation(origin.calibration_id), result.options.Parameters(),
                                    result.fit.scale)
       << "time: " << base::Quoted(origin.time) << "  # of the newest measurement\n";
  if (!origin.surveyor.empty()) text << "operator: " << base::Quoted(origin.surveyor) << "\n";
  text << "control:\n  file: " << base::Quoted(origin.control_file) << "\n  crc32: \"" << origin.control_crc32
       << "\"\n  used: [";
  for (std::size_t i = 0; i < result.used; ++i)
    text << (i == 0 ? "" : ", ") << base::Quoted(result.points[i].common.name);
  text << "]\nquality:\n"
       << std::setprecision(6) << "  sigma0: " << result.fit.sigma0
       << "\n  redundancy: " << result.fit.redundancy << "\n  rms_m: " << result.rms_m
       << "\n  largest_residual_m: " << result.largest_m << "\n  scale_ppm: " << result.scale_ppm
       << "\n  scale_sigma_ppm: " << result.scale_sigma_ppm << "\n";
  return text.str();
}

}  // namespace adit::host
