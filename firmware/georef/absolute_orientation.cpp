#include "firmware/georef/absolute_orientation.h"

#include <iomanip>
#include <sstream>

#include "firmware/base/yaml.h"
#include "firmware/base/yaml_pose.h"

namespace adit::georef {
namespace {

using base::YamlReader;

constexpr base::Range kGridScaleFactor{0.99, 1.01};  // of every projection that surveys use
constexpr base::Range kGridM{-1e8, 1e8};

Eigen::Matrix3d GridScale(double grid_scale_factor) {
  return Eigen::Vector3d(grid_scale_factor, grid_scale_factor, 1).asDiagonal();
}

template <class Values>
void WriteRow(const Values& values, std::ostream& text) {
  text << "[";
  for (Eigen::Index i = 0; i < values.size(); ++i) text << (i == 0 ? "" : ", ") << values[i];
  text << "]";
}

void CheckParameters(YamlReader& in) {
  const long parameters = in.Integer("parameters");
  const double scale = in.NumberOr("scale", 1, {0.5, 2});
  if (parameters == 7) {
    in.Refuse("parameters", "is 7, which is for diagnosis: machines steer by 6, or by 4 with a levelled rig");
  } else if (parameters != 4 && parameters != 6) {
    in.Refuse("parameters", "is " + std::to_string(parameters) + "; it must be 4 or 6");
  } else if (scale != 1) {
    in.Refuse("scale", "must be 1 with 4 or 6 parameters");
  }
}

}  // namespace

Eigen::Vector3d AbsoluteOrientation::Apply(const Eigen::Vector3d& point_b_m) const {
  return T_s_b.translation_m + GridScale(grid_scale_factor) * (T_s_b.rotation * point_b_m);
}

Eigen::Vector3d AbsoluteOrientation::Turn(const Eigen::Vector3d& direction_b) const {
  return (GridScale(grid_scale_factor) * (T_s_b.rotation * direction_b)).normalized();
}

Eigen::Matrix3d AbsoluteOrientation::Propagate(const Eigen::Vector3d& point_b_m,
                                               const Eigen::Matrix3d& covariance_b_m2) const {
  const Eigen::Matrix3d grid = GridScale(grid_scale_factor);
  const Eigen::Matrix3d to_site = grid * T_s_b.rotation;
  // p_s = t_ref + G exp([theta]x) R (p_b - ref): d p_s = -G [R (p_b - ref)]x d theta + d t_ref
  Eigen::Matrix<double, 3, 6> jacobian;
  jacobian.leftCols<3>() = -(grid * base::Skew(T_s_b.rotation * (point_b_m - reference_b_m)));
  jacobian.rightCols<3>().setIdentity();
  return to_site * covariance_b_m2 * to_site.transpose() + jacobian * covariance * jacobian.transpose();
}

base::Result<AbsoluteOrientation> LoadOrientation(const std::string& path,
                                                  const std::string& calibration_id) {
  auto in = YamlReader::OpenFile(path);
  if (!in) return in.error();
  AbsoluteOrientation orientation;
  orientation.T_s_b = base::ReadPose<base::Site, base::Rig>(*in, "T_s_b");
  if (!(orientation.T_s_b.translation_m.cwiseAbs().maxCoeff() <= kGridM.max))
    in->Refuse("T_s_b", "puts the rig more than 1e8 m from the grid's origin");
  orientation.grid_scale_factor = in->Number("grid_scale_factor", kGridScaleFactor);
  CheckParameters(*in);
  const auto reference = in->Numbers("reference_b_m", 3, {-1e4, 1e4});
  if (in->Ok()) orientation.reference_b_m = Eigen::Map<const Eigen::Vector3d>(reference.data());
  base::ReadCovariance(*in, "covariance", orientation.covariance);
  orientation.calibration_id = in->Text("calibration_id");
  if (in->Ok() && orientation.calibration_id != calibration_id) {
    in->Refuse("calibration_id", "is '" + orientation.calibration_id + "' and the rig's is '" +
                                     calibration_id + "'; georeference anew after a calibration");
  }
  // How it came about; for people.
  for (const char* key : {"time", "operator", "control", "quality"}) in->Ignore(key);
  if (auto done = in->Finish(); !done) return done.error();
  return orientation;
}

std::string FormatOrientation(const AbsoluteOrientation& orientation, int parameters, double scale) {
  const auto& [rotation, translation_m] = orientation.T_s_b;
  std::ostringstream text;
  text << std::setprecision(17)
       << "T_s_b:  # maps a point of the rig frame into easting, northing, height; metres\n";
  for (Eigen::Index r = 0; r < 3; ++r) {
    text << "  - ";
    WriteRow(Eigen::Vector4d(rotation(r, 0), rotation(r, 1), rotation(r, 2), translation_m[r]), text);
    text << "\n";
  }
  text << "  - [0, 0, 0, 1]\ngrid_scale_factor: " << orientation.grid_scale_factor
       << "  # of what lies in the plane, from the rig\nparameters: " << parameters << "\nscale: " << scale
       << "\nreference_b_m: ";
  WriteRow(orientation.reference_b_m, text);
  text << "\ncovariance:  # of (rotation vector in the site frame: rad, translation of the reference point: "
          "m)\n";
  for (Eigen::Index r = 0; r < 6; ++r) {
    text << "  - ";
    WriteRow(orientation.covariance.row(r), text);
    text << "\n";
  }
  text << "calibration_id: " << base::Quoted(orientation.calibration_id) << "\n";
  return text.str();
}

}  // namespace adit::georef
