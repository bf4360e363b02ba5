// Every number of firmware/FRAMES.md, recomputed from those it says they follow from.
#include <map>
#include <string>
#include <vector>

#include "firmware/base/pose.h"
#include "firmware/optics/camera_model.h"
#include "tests/support/frames_page.h"

#include <CppUTest/TestHarness.h>

using adit::base::BodyFrame;
using adit::base::LeftCamera;
using adit::base::Pose;
using adit::base::RightCamera;
using adit::base::Site;
using adit::base::TargetFrame;
using Eigen::Vector3d;
using RigFrame = adit::base::Rig;

namespace {

constexpr double kExactM = 1e-12;    // the example's products are exact but for rounding
constexpr double kPrintedPx = 5e-7;  // the page gives six decimals of a pixel

}  // namespace

TEST_GROUP(Frames) {
  std::map<std::string, std::vector<double>> page = adit::tests::ReadFramesPage();

  std::vector<double> Numbers(const std::string& name, std::size_t count) {
    LONGS_EQUAL_TEXT(count, page[name].size(), name.c_str());
    return page[name];
  }
  Vector3d Point(const std::string& name) {
    const auto n = Numbers(name, 3);
    return {n[0], n[1], n[2]};
  }
  template <class To, class From>
  Pose<To, From> ReadPose(const std::string& name) {
    Pose<To, From> pose;
    for (int r = 0; r < 3; ++r) {
      const auto row = Numbers(name + "_row" + std::to_string(r), 4);
      for (int c = 0; c < 3; ++c) pose.rotation(r, c) = row[static_cast<std::size_t>(c)];
      pose.translation_m[r] = row[3];
    }
    return pose;
  }
  adit::optics::CameraModel Camera() {
    const auto n = Numbers("intrinsics_px", 4);
    return {n[0], n[1], n[2], n[3], 0, 0, 0, 0, 1400, 1024};
  }
  void CheckSame(const Vector3d& expected, const Vector3d& actual) {
    for (int i = 0; i < 3; ++i) DOUBLES_EQUAL(expected[i], actual[i], kExactM);
  }
  void CheckPixel(const std::string& name, const Vector3d& point_m) {
    const auto expected = Numbers(name, 2);
    const auto pixel = Camera().Project(point_m);
    CHECK(pixel.has_value());
    DOUBLES_EQUAL(expected[0], pixel->x(), kPrintedPx);
    DOUBLES_EQUAL(expected[1], pixel->y(), kPrintedPx);
  }
};

TEST(Frames, AllPosesAreRotationsOfRightHandedFrames) {
  for (const char* name : {"T_r_l", "T_b_t", "T_s_b", "T_b_body"}) {
    const auto pose = ReadPose<Site, RigFrame>(name);
    CHECK_TRUE(pose.rotation.isUnitary(kExactM));
    DOUBLES_EQUAL(1, pose.rotation.determinant(), kExactM);
  }
}

TEST(Frames, TheRightCameraStandsWhereItsPoseSays) {
  CheckSame(Point("centre_of_r_in_l"), (ReadPose<RightCamera, LeftCamera>("T_r_l").Inverse().translation_m));
}

TEST(Frames, TheLedIsSeenFromTheRightAsThePageSays) {
  CheckSame(Point("led1_in_r"), ReadPose<RightCamera, LeftCamera>("T_r_l") * Point("led1_in_l"));
}

TEST(Frames, TheLedFallsOnThePixelsOfThePage) {
  CheckPixel("led1_in_left_image_px", Point("led1_in_l"));
  CheckPixel("led1_in_right_image_px", Point("led1_in_r"));
}

TEST(Frames, TheBarLeadsFromLed1ToLed4AndBackToTheEpicenter) {
  const auto T_b_t = ReadPose<RigFrame, TargetFrame>("T_b_t");
  CheckSame(Point("led1_in_l"), T_b_t * Vector3d(0, 0, 0));
  CheckSame(Point("led4_in_b"), T_b_t * Point("led4_in_t"));
  CheckSame(Point("epicenter_in_b"), T_b_t * Point("epicenter_in_t"));
}

TEST(Frames, TheSiteGridHasThePointsOfThePage) {
  const auto T_s_b = ReadPose<Site, RigFrame>("T_s_b");
  CheckSame(Point("led1_in_s"), T_s_b * Point("led1_in_l"));
  const auto T_s_t = T_s_b * ReadPose<RigFrame, TargetFrame>("T_b_t");
  CheckSame(Point("epicenter_in_s"), T_s_t * Point("epicenter_in_t"));
}

TEST(Frames, TheBodyStandsOnTheGridAndCarriesItsBarAsThePageSays) {
  const auto T_b_t = ReadPose<RigFrame, BodyFrame>("T_b_body");
  CheckSame(Point("bar_led1_in_b"), T_b_t * Point("bar_led1_in_body"));
  const auto T_s_t = ReadPose<Site, RigFrame>("T_s_b") * T_b_t;
  const auto expected = ReadPose<Site, BodyFrame>("T_s_body");
  CheckSame(expected.translation_m, T_s_t.translation_m);
  for (int axis = 0; axis < 3; ++axis) CheckSame(expected.rotation.col(axis), T_s_t.rotation.col(axis));
}
