#include "firmware/optics/rig.h"

#include <Eigen/LU>
#include <cmath>
#include <iomanip>
#include <sstream>

#include "firmware/base/yaml.h"
#include "firmware/base/yaml_pose.h"

namespace adit::optics {
namespace {

using base::Range;
using base::YamlReader;

constexpr Range kFocalPx{100, 100000};     // a fisheye of 1 Mpx to a telescope
constexpr Range kCentrePx{-10000, 20000};  // a shifted lens still ends here
constexpr Range kResolutionPx{16, 16384};
constexpr Range kDistortion{-10, 10};
constexpr double kShortestBaselineM = 0.1, kLongestBaselineM = 50;

std::string Row(std::initializer_list<double> values) {
  std::ostringstream text;
  text << std::setprecision(17) << "[";
  const char* separator = "";
  for (const double value : values) {
    text << separator << value;
    separator = ", ";
  }
  text << "]";
  return text.str();
}

/// Short, unlike std::to_string, and not rounded to zero.
std::string Show(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

/// Refuses a camera that no lens makes; `intrinsics` is the key it came from.
void CheckPlausible(YamlReader& in, const CameraModel& camera, const char* intrinsics) {
  for (const double focal_px : {camera.fu_px, camera.fv_px}) {
    if (!(focal_px >= kFocalPx.min && focal_px <= kFocalPx.max)) {
      in.Refuse(intrinsics, "has a focal length of " + Show(focal_px) + " px; it must be from " +
                                Show(kFocalPx.min) + " to " + Show(kFocalPx.max) + " px");
    }
  }
  for (const double centre_px : {camera.cu_px, camera.cv_px}) {
    if (!(centre_px >= kCentrePx.min && centre_px <= kCentrePx.max)) {
      in.Refuse(intrinsics, "has its principal point at " + Show(centre_px) + " px; it must be from " +
                                Show(kCentrePx.min) + " to " + Show(kCentrePx.max) + " px");
    }
  }
}

/// The keys of one camera as EuRoC and Kalibr name them; they differ in the distortion's.
CameraModel ReadCamera(YamlReader& in, bool kalibr) {
  in.Choice("camera_model", {"pinhole"});
  in.Choice("distortion_model", {kalibr ? "radtan" : "radial-tangential"});
  const auto intrinsics = in.Numbers("intrinsics", 4);
  const auto distortion =
      in.Numbers(kalibr ? "distortion_coeffs" : "distortion_coefficients", 4, kDistortion);
  const auto resolution = in.Numbers("resolution", 2, kResolutionPx);
  if (!in.Ok()) return {};
  for (const double side_px : resolution) {
    if (side_px != std::floor(side_px))
      in.Refuse("resolution", "holds " + Show(side_px) + "; pixels are whole");
  }
  const CameraModel camera{intrinsics[0],
                           intrinsics[1],
                           intrinsics[2],
                           intrinsics[3],
                           distortion[0],
                           distortion[1],
                           distortion[2],
                           distortion[3],
                           static_cast<int>(resolution[0]),
                           static_cast<int>(resolution[1])};
  CheckPlausible(in, camera, "intrinsics");
  return camera;
}

CameraModel ReadOpenCvMatrices(YamlReader& in) {
  YamlReader matrix = in.Child("camera_matrix");
  YamlReader coefficients = in.Child("distortion_coefficients");
  const auto k = matrix.Numbers("data", 9);
  const auto d = coefficients.Numbers("data", 0, kDistortion);
  for (YamlReader* part : {&matrix, &coefficients}) {
    for (const char* key : {"rows", "cols", "dt"}) part->Ignore(key);
  }
  const long width_px = in.Integer("image_width", kResolutionPx);
  const long height_px = in.Integer("image_height", kResolutionPx);
  if (in.Ok() && (d.size() < 4 || d.size() > 5 || (d.size() == 5 && d[4] != 0))) {
    in.Refuse("distortion_coefficients", "has " + std::to_string(d.size()) + " values" +
                                             (d.size() == 5 ? ", k3 = " + Show(d[4]) : "") +
                                             "; adit's model has k1, k2, p1, p2 (a fifth, k3, must be 0)");
  }
  if (in.Ok() && !(k[1] == 0 && k[3] == 0 && k[6] == 0 && k[7] == 0 && k[8] == 1))
    in.Refuse("camera_matrix", "is not of the form [fu, 0, cu, 0, fv, cv, 0, 0, 1]");
  if (!in.Ok()) return {};
  const CameraModel camera{k[0],
                           k[4],
                           k[2],
                           k[5],
                           d[0],
                           d[1],
                           d[2],
                           d[3],
                           static_cast<int>(width_px),
                           static_cast<int>(height_px)};
  CheckPlausible(in, camera, "camera_matrix");
  return camera;
}

base::Pose<base::RightCamera, base::LeftCamera> ReadExtrinsics(YamlReader& cam1) {
  const char* const key = "T_cn_cnm1";
  const auto pose = base::ReadPose<base::RightCamera, base::LeftCamera>(cam1, key);
  if (!cam1.Ok()) return pose;
  const double baseline_m = pose.translation_m.norm();
  if (!(baseline_m >= kShortestBaselineM && baseline_m <= kLongestBaselineM)) {
    cam1.Refuse(key, "has a baseline of " + Show(baseline_m) + " m; it must be from " +
                         Show(kShortestBaselineM) + " to " + Show(kLongestBaselineM) + " m");
  }
  // The right camera's centre in the left frame is -R^T t; to the right means x > 0.
  const double centre_x_m = pose.Inverse().translation_m.x();
  if (!(centre_x_m > 0)) {
    cam1.Refuse(key, "puts cam1 at x = " + Show(centre_x_m) +
                         " m, left of cam0; cam0 must be the left camera (baseline sign)");
  }
  return pose;
}

}  // namespace

Eigen::Matrix3d Rig::Fundamental() const {
  const Eigen::Matrix3d essential = base::Skew(T_r_l.translation_m) * T_r_l.rotation;
  return right.K().inverse().transpose() * essential * left.K().inverse();
}

base::Result<CameraModel> LoadCamera(const std::string& path) {
  auto in = YamlReader::OpenFile(path);
  if (!in) return in.error();
  const bool opencv = in->Has("camera_matrix");
  const CameraModel camera = opencv ? ReadOpenCvMatrices(*in) : ReadCamera(*in, false);
  // EuRoC, Kalibr and OpenCV tools write more than adit needs; in a camera file, foreign keys are no mistake.
  for (const std::string& key : in->Keys()) in->Ignore(key);
  if (auto done = in->Finish(); !done) return done.error();
  return camera;
}

std::string FormatCamera(const CameraModel& camera) {
  std::ostringstream text;
  text << "sensor_type: camera\ncamera_model: pinhole\n"
       << "intrinsics: " << Row({camera.fu_px, camera.fv_px, camera.cu_px, camera.cv_px})
       << "  # fu, fv, cu, cv in px\ndistortion_model: radial-tangential\n"
       << "distortion_coefficients: " << Row({camera.k1, camera.k2, camera.p1, camera.p2})
       << "  # k1, k2, p1, p2\n"
       << "resolution: [" << camera.width_px << ", " << camera.height_px << "]\n";
  return text.str();
}

base::Result<std::optional<RigCovariance>> LoadRigCovariance(const std::string& path) {
  auto in = YamlReader::OpenFile(path);
  if (!in) return in.error();
  const char* const key = "covariance";
  if (!in->Has(key)) return std::optional<RigCovariance>{};
  const auto values = in->Matrix(key, kRigParameters, kRigParameters);
  for (const std::string& other : in->Keys()) in->Ignore(other);
  RigCovariance covariance = RigCovariance::Zero();
  if (in->Ok()) {
    covariance = Eigen::Map<const Eigen::Matrix<double, kRigParameters, kRigParameters, Eigen::RowMajor>>(
        values.data());
    const Eigen::VectorXd sigma = covariance.diagonal().cwiseMax(0).cwiseSqrt();
    constexpr double kRounding = 1e-8;  // twelve digits are written
    const RigCovariance skew = covariance - covariance.transpose();
    if (!(covariance.diagonal().minCoeff() >= 0) ||
        !(skew.cwiseAbs().array() <= kRounding * (sigma * sigma.transpose()).array()).all())
      in->Refuse(key, "is no covariance: it must be symmetric, without negative variances");
  }
  if (auto done = in->Finish(); !done) return done.error();
  return std::optional<RigCovariance>{covariance};
}

std::string FormatRigCovariance(const RigCovariance& covariance) {
  std::ostringstream text;
  text << "covariance:  # of rotation vector (rad) and translation (m) in cam1's frame, then fu, fv, cu, cv "
          "(px),\n"
       << "             # k1, k2, p1, p2 of cam0 and of cam1\n"
       << std::setprecision(12);
  for (Eigen::Index r = 0; r < covariance.rows(); ++r) {
    text << "  - [";
    for (Eigen::Index c = 0; c < covariance.cols(); ++c) text << (c == 0 ? "" : ", ") << covariance(r, c);
    text << "]\n";
  }
  return text.str();
}

base::Result<Rig> LoadRig(const std::string& path) {
  auto in = YamlReader::OpenFile(path);
  if (!in) return in.error();
  Rig rig;
  YamlReader cam0 = in->Child("cam0");
  YamlReader cam1 = in->Child("cam1");
  rig.left = ReadCamera(cam0, true);
  rig.right = ReadCamera(cam1, true);
  rig.T_r_l = ReadExtrinsics(cam1);
  rig.calibration_id = in->TextOr("calibration_id", "unnamed");
  // It goes into rows of CSV.
  if (rig.calibration_id.find_first_of(",\"\\\n\r\t") != std::string::npos)
    in->Refuse("calibration_id", "must not hold commas, quotes, backslashes, tabs or line ends");
  // Kalibr's own extras, and adit's that say how the calibration came about.
  for (const char* key : {"time", "covariance", "quality", "verdict"}) in->Ignore(key);
  for (YamlReader* camera : {&cam0, &cam1}) {
    for (const char* key : {"rostopic", "cam_overlaps", "timeshift_cam_imu", "T_cam_imu"})
      camera->Ignore(key);
  }
  if (auto done = in->Finish(); !done) return done.error();
  return rig;
}

std::string FormatRig(const Rig& rig) {
  std::ostringstream text;
  const auto camera = [&text](const char* name, const CameraModel& c) {
    text << name << ":\n  camera_model: pinhole\n  intrinsics: " << Row({c.fu_px, c.fv_px, c.cu_px, c.cv_px})
         << "\n  distortion_model: radtan\n  distortion_coeffs: " << Row({c.k1, c.k2, c.p1, c.p2})
         << "\n  resolution: [" << c.width_px << ", " << c.height_px << "]\n";
  };
  camera("cam0", rig.left);
  camera("cam1", rig.right);
  const Eigen::Matrix3d& r = rig.T_r_l.rotation;
  const Eigen::Vector3d& t = rig.T_r_l.translation_m;
  text << "  T_cn_cnm1:  # maps a point of cam0 into cam1, metres\n";
  for (int i = 0; i < 3; ++i) text << "    - " << Row({r(i, 0), r(i, 1), r(i, 2), t[i]}) << "\n";
  text << "    - [0, 0, 0, 1]\ncalibration_id: " << base::Quoted(rig.calibration_id) << "\n";
  return text.str();
}

}  // namespace adit::optics
