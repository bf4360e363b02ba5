#include "firmware/optics/rig.h"

#include <stdlib.h>

#include <Eigen/Geometry>
#include <filesystem>
#include <fstream>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <random>

#include <CppUTest/TestHarness.h>

using adit::optics::CameraModel;
using adit::optics::FormatCamera;
using adit::optics::FormatRig;
using adit::optics::LoadCamera;
using adit::optics::LoadRig;
using adit::optics::Rig;
using Eigen::Vector3d;
namespace fs = std::filesystem;

namespace {

constexpr unsigned kRigSeed = 47;

/// Nine metres apart, turned inwards to meet at 35 m, a little rolled; no two numbers alike.
Rig TunnelRig() {
  Rig rig;
  rig.left = {3401.25, 3399.5, 701.125, 509.75, -0.21, 0.13, 3e-4, -2e-4, 1400, 1024};
  rig.right = {3388.5, 3390.25, 688.5, 515.25, -0.19, 0.11, -1e-4, 4e-4, 1400, 1024};
  rig.T_r_l.rotation =
      (Eigen::AngleAxisd(0.25, Vector3d::UnitY()) * Eigen::AngleAxisd(0.01, Vector3d::UnitX()) *
       Eigen::AngleAxisd(-0.007, Vector3d::UnitZ()))
          .toRotationMatrix();
  rig.T_r_l.translation_m = -(rig.T_r_l.rotation * Vector3d(9, 0.05, -0.1));
  rig.calibration_id = "2026-03-04 north";
  return rig;
}

bool Same(const CameraModel& a, const CameraModel& b) {
  return a.fu_px == b.fu_px && a.fv_px == b.fv_px && a.cu_px == b.cu_px && a.cv_px == b.cv_px &&
         a.k1 == b.k1 && a.k2 == b.k2 && a.p1 == b.p1 && a.p2 == b.p2 && a.width_px == b.width_px &&
         a.height_px == b.height_px;
}

std::string Replace(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  CHECK_TEXT(at != std::string::npos, from.c_str());
  return text.replace(at, from.size(), to);
}

}  // namespace

TEST_GROUP(RigFile) {
  fs::path folder;
  std::string path;
  void setup() override {
    std::string name = (fs::temp_directory_path() / "adit-rig-XXXXXX").string();
    CHECK(mkdtemp(name.data()) != nullptr);
    folder = name;
    path = (folder / "f.yaml").string();
  }
  void teardown() override { fs::remove_all(folder); }

  /// What LoadRig says of `text`, without the folder; "" if nothing is wrong.
  std::string RigComplaint(const std::string& text) {
    std::ofstream(path) << text;
    const auto rig = LoadRig(path);
    return rig ? "" : Replace(rig.error().Line(), path, "f.yaml");
  }
  std::string CameraComplaint(const std::string& text) {
    std::ofstream(path) << text;
    const auto camera = LoadCamera(path);
    return camera ? "" : Replace(camera.error().Line(), path, "f.yaml");
  }
  void Refuses(const std::string& expected, const Rig& rig) {
    STRCMP_EQUAL(expected.c_str(), RigComplaint(FormatRig(rig)).c_str());
  }
};

TEST(RigFile, ReadsBackWhatItWroteToTheLastBit) {
  const Rig rig = TunnelRig();
  std::ofstream(path) << FormatRig(rig);
  const auto again = LoadRig(path);
  CHECK(!!again);
  CHECK_TRUE(Same(rig.left, again->left));
  CHECK_TRUE(Same(rig.right, again->right));
  CHECK_TRUE(rig.T_r_l.rotation == again->T_r_l.rotation);
  CHECK_TRUE(rig.T_r_l.translation_m == again->T_r_l.translation_m);
  STRCMP_EQUAL(rig.calibration_id.c_str(), again->calibration_id.c_str());
  std::ofstream(path) << FormatCamera(rig.right);
  const auto camera = LoadCamera(path);
  CHECK(!!camera);
  CHECK_TRUE(Same(rig.right, *camera));
}

TEST(RigFile, ReadsACamchainAsKalibrWritesIt) {
  // The layout of Kalibr's wiki page "YAML formats", with this rig's sizes.
  std::ofstream(path) << "cam0:\n  cam_overlaps: [1]\n  camera_model: pinhole\n"
                         "  distortion_coeffs: [-0.2, 0.1, 0.001, -0.001]\n  distortion_model: radtan\n"
                         "  intrinsics: [3400.5, 3401.5, 700.5, 512.5]\n  resolution: [1400, 1024]\n"
                         "  rostopic: /cam0/image_raw\ncam1:\n  T_cn_cnm1:\n"
                         "  - [1.0, 0.0, 0.0, -9.0]\n  - [0.0, 1.0, 0.0, 0.0]\n  - [0.0, 0.0, 1.0, 0.0]\n"
                         "  - [0.0, 0.0, 0.0, 1.0]\n  cam_overlaps: [0]\n  camera_model: pinhole\n"
                         "  distortion_coeffs: [-0.1, 0.2, 0.002, -0.002]\n  distortion_model: radtan\n"
                         "  intrinsics: [3300.5, 3301.5, 701.5, 513.5]\n  resolution: [1400, 1024]\n"
                         "  rostopic: /cam1/image_raw\n";
  const auto rig = LoadRig(path);
  CHECK(!!rig);
  CHECK_TRUE(Same(rig->left, {3400.5, 3401.5, 700.5, 512.5, -0.2, 0.1, 0.001, -0.001, 1400, 1024}));
  CHECK_TRUE(Same(rig->right, {3300.5, 3301.5, 701.5, 513.5, -0.1, 0.2, 0.002, -0.002, 1400, 1024}));
  DOUBLES_EQUAL(9, rig->BaselineM(), 0);
  DOUBLES_EQUAL(9, rig->T_r_l.Inverse().translation_m.x(), 0);
  STRCMP_EQUAL("unnamed", rig->calibration_id.c_str());
}

TEST(RigFile, RefusesTheWrongBaselineSign) {
  Rig rig = TunnelRig();
  rig.T_r_l.rotation.setIdentity();
  rig.T_r_l.translation_m = {9, 0, 0};
  Refuses(
      "f.yaml: cam1.T_cn_cnm1: puts cam1 at x = -9 m, left of cam0; cam0 must be the left camera "
      "(baseline sign)",
      rig);
}

TEST(RigFile, RefusesABaselineThatNobodyBuilds) {
  Rig rig = TunnelRig();
  rig.T_r_l.rotation.setIdentity();
  rig.T_r_l.translation_m = {-9000, 0, 0};  // millimetres
  Refuses("f.yaml: cam1.T_cn_cnm1: has a baseline of 9000 m; it must be from 0.1 to 50 m", rig);
  rig.T_r_l.translation_m = {0, 0, 0};
  Refuses("f.yaml: cam1.T_cn_cnm1: has a baseline of 0 m; it must be from 0.1 to 50 m", rig);
}

TEST(RigFile, RefusesWhatIsNoRotation) {
  Rig rig = TunnelRig();
  rig.T_r_l.rotation.setIdentity();
  rig.T_r_l.rotation(0, 0) = 1.001;
  Refuses(
      "f.yaml: cam1.T_cn_cnm1: has no rotation in its upper left 3 x 3 block: R R^T differs from 1 by "
      "0.002001; at most 1e-06 is allowed",
      rig);
  rig.T_r_l.rotation(0, 0) = -1;
  Refuses(
      "f.yaml: cam1.T_cn_cnm1: has a mirror in its upper left 3 x 3 block (determinant -1); it must be "
      "a rotation",
      rig);
}

TEST(RigFile, RefusesALastRowThatIsNotOfAPose) {
  STRCMP_EQUAL("f.yaml: cam1.T_cn_cnm1[3]: is not [0, 0, 0, 1]",
               RigComplaint(Replace(FormatRig(TunnelRig()), "[0, 0, 0, 1]", "[0, 0, 1, 1]")).c_str());
}

TEST(RigFile, NamesEachMissingKey) {
  const std::string whole = FormatRig(TunnelRig());
  for (const std::string key :
       {"camera_model", "intrinsics", "distortion_model", "distortion_coeffs", "resolution", "T_cn_cnm1"}) {
    const std::string camera = key == "T_cn_cnm1" ? "cam1" : "cam0";
    const std::string line = RigComplaint(Replace(whole, "  " + key + ":", "  rostopic:"));
    STRCMP_CONTAINS(("f.yaml: " + camera + "." + key + ": is missing; it must be ").c_str(), line.c_str());
  }
  STRCMP_EQUAL("f.yaml: cam1: is missing; it must be a map",
               RigComplaint(whole.substr(0, whole.find("cam1:"))).c_str());
}

TEST(RigFile, RefusesAnUnknownKeyAndListsTheKnown) {
  STRCMP_EQUAL(
      "f.yaml: calibration: is not known here; known: calibration_id, cam0, cam1, covariance, "
      "quality, time, verdict",
      RigComplaint(FormatRig(TunnelRig()) + "calibration: 3\n").c_str());
}

TEST(RigFile, RefusesThreeDistortionCoefficients) {
  Rig rig = TunnelRig();
  const std::string text = Replace(FormatRig(rig), ", -0.00020000000000000001]", "]");
  STRCMP_EQUAL(
      "f.yaml: cam0.distortion_coeffs: is a list of 3; it must be a list of 4, each a number from "
      "-10 to 10",
      RigComplaint(text).c_str());
}

TEST(RigFile, RefusesModelsThatItDoesNotCompute) {
  const std::string whole = FormatRig(TunnelRig());
  STRCMP_EQUAL("f.yaml: cam0.camera_model: is 'omni'; it must be one of: pinhole",
               RigComplaint(Replace(whole, "pinhole", "omni")).c_str());
  STRCMP_EQUAL("f.yaml: cam0.distortion_model: is 'equidistant'; it must be one of: radtan",
               RigComplaint(Replace(whole, "radtan", "equidistant")).c_str());
}

TEST(RigFile, RefusesSizesThatNoCameraHas) {
  Rig rig = TunnelRig();
  rig.left.fv_px = -3400;
  Refuses("f.yaml: cam0.intrinsics: has a focal length of -3400 px; it must be from 100 to 100000 px", rig);
  rig = TunnelRig();
  rig.right.cu_px = 1e5;
  Refuses("f.yaml: cam1.intrinsics: has its principal point at 100000 px; it must be from -10000 to 20000 px",
          rig);
  rig = TunnelRig();
  rig.left.height_px = 0;
  Refuses("f.yaml: cam0.resolution[1]: is '0'; it must be a number from 16 to 16384", rig);
  STRCMP_EQUAL("f.yaml: cam0.resolution: holds 1400.5; pixels are whole",
               RigComplaint(Replace(FormatRig(TunnelRig()), "1400,", "1400.5,")).c_str());
}

TEST(RigFile, RefusesANameThatWouldBreakATable) {
  Rig rig = TunnelRig();
  rig.calibration_id = "a, b";
  Refuses("f.yaml: calibration_id: must not hold commas, quotes, backslashes, tabs or line ends", rig);
}

TEST(RigFile, ReadsACameraAsEurocWritesIt) {
  // The keys and layout of the EuRoC MAV data set's sensor.yaml (Burri et al., IJRR 2016).
  std::ofstream(path) << "# General sensor definitions.\nsensor_type: camera\ncomment: VI-Sensor cam0\n\n"
                         "T_BS:\n  cols: 4\n  rows: 4\n  data: [1.0, 0.0, 0.0, 0.1,\n         0.0, 1.0, 0.0, "
                         "0.2,\n         0.0, 0.0, 1.0, 0.3,\n         0.0, 0.0, 0.0, 1.0]\n\nrate_hz: 20\n"
                         "resolution: [752, 480]\ncamera_model: pinhole\n"
                         "intrinsics: [458.654, 457.296, 367.215, 248.375] #fu, fv, cu, cv\n"
                         "distortion_model: radial-tangential\n"
                         "distortion_coefficients: [-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05]\n";
  const auto camera = LoadCamera(path);
  CHECK(!!camera);
  CHECK_TRUE(Same(*camera, {458.654, 457.296, 367.215, 248.375, -0.28340811, 0.07395907, 0.00019359,
                            1.76187114e-05, 752, 480}));
}

TEST(RigFile, ReadsACameraAsOpenCvWritesIt) {
  for (const int count : {4, 5}) {
    const cv::Mat k = (cv::Mat_<double>(3, 3) << 3400.125, 0, 700.1, 0, 3390.3, 511.7, 0, 0, 1);
    cv::Mat d = (cv::Mat_<double>(1, 5) << -0.21, 0.13, 3e-4, -2e-4, 0);
    cv::FileStorage file(path, cv::FileStorage::WRITE);
    file << "calibration_time"
         << "today"
         << "image_width" << 1400 << "image_height" << 1024 << "camera_matrix" << k
         << "distortion_coefficients" << d.colRange(0, count) << "avg_reprojection_error" << 0.11;
    file.release();
    const auto camera = LoadCamera(path);
    CHECK(!!camera);
    CHECK_TRUE(Same(*camera, {3400.125, 3390.3, 700.1, 511.7, -0.21, 0.13, 3e-4, -2e-4, 1400, 1024}));
  }
}

TEST(RigFile, RefusesOpenCvFilesOfOtherModels) {
  const std::string head = "%YAML:1.0\n---\nimage_width: 1400\nimage_height: 1024\n";
  const std::string k =
      "camera_matrix: {rows: 3, cols: 3, dt: d, data: [3400, 0, 700, 0, 3400, 511, 0, 0, 1]}\n";
  const std::string d = "distortion_coefficients: {rows: 1, cols: 4, dt: d, data: [0, 0, 0, 0]}\n";
  STRCMP_EQUAL("", CameraComplaint(head + k + d).c_str());
  STRCMP_EQUAL(
      "f.yaml: distortion_coefficients: has 5 values, k3 = 0.1; adit's model has k1, k2, p1, p2 (a "
      "fifth, k3, must be 0)",
      CameraComplaint(head + k + Replace(d, "0, 0]", "0, 0, 0.1]")).c_str());
  STRCMP_EQUAL(
      "f.yaml: distortion_coefficients: has 3 values; adit's model has k1, k2, p1, p2 (a fifth, k3, "
      "must be 0)",
      CameraComplaint(head + k + Replace(d, "0, 0]", "0]")).c_str());
  STRCMP_EQUAL("f.yaml: camera_matrix: is not of the form [fu, 0, cu, 0, fv, cv, 0, 0, 1]",
               CameraComplaint(head + Replace(k, "3400, 0", "3400, 0.5") + d).c_str());
  STRCMP_EQUAL("f.yaml: camera_matrix: has a focal length of 3.4 px; it must be from 100 to 100000 px",
               CameraComplaint(head + Replace(k, "3400", "3.4") + d).c_str());
  STRCMP_EQUAL("f.yaml: image_width: is missing; it must be a number from 16 to 16384",
               CameraComplaint(Replace(head, "image_width", "width") + k + d).c_str());
}

TEST(RigFile, NamesAMissingFile) {
  fs::remove(path);
  const auto rig = LoadRig(path);
  CHECK_FALSE(rig);
  STRCMP_EQUAL((path + ": cannot be read: No such file or directory").c_str(), rig.error().Line().c_str());
  LONGS_EQUAL(1, rig.error().ExitCode());
}

TEST_GROUP(Rig){};

TEST(Rig, ItsFundamentalMatrixPutsMatchesOnEpipolarLines_Seed47) {
  const Rig rig = TunnelRig();
  const Eigen::Matrix3d fundamental = rig.Fundamental();
  std::mt19937 random(kRigSeed);
  std::uniform_real_distribution<double> across_m(-4, 8), depth_m(10, 120);
  cv::Mat rotation(3, 3, CV_64F), turn;
  for (int i = 0; i < 9; ++i) rotation.at<double>(i / 3, i % 3) = rig.T_r_l.rotation(i / 3, i % 3);
  cv::Rodrigues(rotation, turn);
  const Vector3d& t = rig.T_r_l.translation_m;
  const auto matrix = [](const CameraModel& c) {
    return cv::Matx33d(c.fu_px, 0, c.cu_px, 0, c.fv_px, c.cv_px, 0, 0, 1);
  };
  for (int i = 0; i < 200; ++i) {
    const std::vector<cv::Point3d> point{{across_m(random), across_m(random), depth_m(random)}};
    std::vector<cv::Point2d> left, right;
    cv::projectPoints(point, cv::Vec3d(0, 0, 0), cv::Vec3d(0, 0, 0), matrix(rig.left), cv::noArray(), left);
    cv::projectPoints(point, turn, cv::Vec3d(t.x(), t.y(), t.z()), matrix(rig.right), cv::noArray(), right);
    const Vector3d line = fundamental * Vector3d(left[0].x, left[0].y, 1);
    const double distance_px = Vector3d(right[0].x, right[0].y, 1).dot(line) / line.head<2>().norm();
    DOUBLES_EQUAL(0, distance_px, 1e-8);
  }
}

TEST(Rig, ItsFundamentalMatrixHasTheOtherCentresAsItsKernels) {
  const Rig rig = TunnelRig();
  const Eigen::Matrix3d fundamental = rig.Fundamental();
  const Vector3d left_epipole = rig.left.K() * rig.T_r_l.Inverse().translation_m;
  const Vector3d right_epipole = rig.right.K() * rig.T_r_l.translation_m;
  DOUBLES_EQUAL(0, (fundamental * left_epipole.normalized()).norm() / fundamental.norm(), 1e-12);
  DOUBLES_EQUAL(0, (fundamental.transpose() * right_epipole.normalized()).norm() / fundamental.norm(), 1e-12);
}
