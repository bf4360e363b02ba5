#include "firmware/optics/rig.h"

#include <Eigen/LU>
#include <cmath>
#include <iomanip>
#include <sstream>

#include "firmware/base/yaml.h"

namespace adit::optics {
namespace {

using base::Range;
using base::YamlReader;

constexpr Range kFocalPx{100, 100000};     // a fisheye of 1 Mpx to a telescope
constexpr Range kCentrePx{-10000, 20000};  // a shifted lens still ends here
constexpr Range kResolutionPx{16, 16384};
constexpr Range kDistortion{-10, 10};
constexpr double kShortestBaselineM = 0.1, kLongestBaselineM = 50;
constexpr double kOrthonormalTolerance = 1e-6;  // a file of 9 digits keeps rotations this well

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

/// The keys of one camera as EuRoC and Kalibr name them; they differ in the distortion's.
CameraModel ReadCamera(YamlReader& in, bool kalibr) {
  CameraModel camera;
  in.Choice("camera_model", {"pinhole"});
  in.Choice("distortion_model", {kalibr ? "radtan" : "radial-tangential"});
  const auto intrinsics = in.Numbers("intrinsics", 4);
  const auto distortion =
      in.Numbers(kalibr ? "distortion_coeffs" : "distortion_coefficients", 4, kDistortion);
  const auto resolution = in.Numbers("resolution", 2, kResolutionPx);
  if (!in.Ok()) return camera;
  for (const int i : {0, 1}) {
    const double focal = intrinsics[static_cast<std::size_t>(i)];
    const double centre = intrinsics[static_cast<std::size_t>(i) + 2];
    if (focal < kFocalPx.min || focal > kFocalPx.max) {
      in.Refuse("intrinsics",
                "has a focal length of " + std::to_string(focal) + "; it must be from 100 to 100000 px");
    }
    if (centre < kCentrePx.min || centre > kCentrePx.max) {
      in.Refuse("intrinsics", "has its principal point at " + std::to_string(centre) +
                                  "; it must be from -10000 to 20000 px");
    }
  }
  camera = {intrinsics[0],
            intrinsics[1],
            intrinsics[2],
            intrinsics[3],
            distortion[0],
            distortion[1],
            distortion[2],
            distortion[3],
            static_cast<int>(resolution[0]),
            static_cast<int>(resolution[1])};
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
  const double width = in.Number("image_width", kResolutionPx);
  const double height = in.Number("image_height", kResolutionPx);
  if (in.Ok() && (d.size() < 4 || d.size() > 5 || (d.size() == 5 && d[4] != 0))) {
    in.Refuse("distortion_coefficients",
              "has " + std::to_string(d.size()) +
                  " values; adit's model has k1, k2, p1, p2 (a fifth, k3, must be 0)");
  }
  if (!in.Ok()) return {};
  return {k[0], k[4], k[2], k[5], d[0], d[1], d[2], d[3], static_cast<int>(width), static_cast<int>(height)};
}

base::Pose<base::RightCamera, base::LeftCamera> ReadExtrinsics(YamlReader& cam1) {
  base::Pose<base::RightCamera, base::LeftCamera> pose;
  const auto rows = cam1.Matrix("T_cn_cnm1", 4, 4);
  if (!cam1.Ok()) return pose;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) pose.rotation(r, c) = rows[static_cast<std::size_t>(4 * r + c)];
    pose.translation_m[r] = rows[static_cast<std::size_t>(4 * r + 3)];
  }
  const double miss =
      (pose.rotation * pose.rotation.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (miss > kOrthonormalTolerance || pose.rotation.determinant() < 0) {
    cam1.Refuse("T_cn_cnm1",
                "has no rotation in its upper left 3 x 3 block (off by " + std::to_string(miss) + ")");
  }
  const double baseline_m = pose.translation_m.norm();
  if (baseline_m < kShortestBaselineM || baseline_m > kLongestBaselineM) {
    cam1.Refuse("T_cn_cnm1",
                "has a baseline of " + std::to_string(baseline_m) + " m; it must be from 0.1 to 50 m");
  }
  // The right camera's centre in the left frame is -R^T t; to the right means x > 0.
  const double centre_x_m = pose.Inverse().translation_m.x();
  if (centre_x_m <= 0) {
    cam1.Refuse("T_cn_cnm1", "puts cam1 at x = " + std::to_string(centre_x_m) +
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
  // Kalibr's own extras, and adit's that say how the calibration came about.
  for (const char* key : {"time", "covariance", "quality"}) in->Ignore(key);
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
  text << "    - [0, 0, 0, 1]\ncalibration_id: \"" << rig.calibration_id << "\"\n";
  return text.str();
}

}  // namespace adit::optics
