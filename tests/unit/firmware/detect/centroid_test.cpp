// Centroid and second moments against OpenCV's moments, the covariance against derivatives of the centroid.
#include "firmware/detect/centroid.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <random>
#include <vector>

#include "firmware/detect/components.h"
#include "tests/support/opencv_view.h"

#include <CppUTest/TestHarness.h>

namespace {

using adit::base::ImageView;
using adit::detect::Components;
using adit::detect::PixelNoise;
using adit::detect::Run;
using adit::detect::SpotMoments;
using adit::support::ViewOf;
using adit::support::WholeOf;

const PixelNoise kNoise{1.5, 40, 8};

double ValueAt(const cv::Mat& image, int x, int y) {
  return image.elemSize() == 1 ? image.at<std::uint8_t>(y, x) : image.at<std::uint16_t>(y, x);
}

SpotMoments MomentsOf(const cv::Mat& image, const adit::detect::RunList& runs,
                      const Eigen::Vector2i& origin_px, int threshold) {
  return {adit::detect::SumLight(ViewOf(image), runs, origin_px, threshold), origin_px, threshold, kNoise};
}

/// A component by both ways: the room's sums, and a picture of its weights for OpenCV.
struct Pair {
  SpotMoments moments;
  cv::Mat weights;
  double peak_dn = 0;
};

std::vector<Pair> PairsOf(const cv::Mat& image, int threshold) {
  static auto components = std::make_unique<Components>();
  CHECK(components->Segment(ViewOf(image), WholeOf(ViewOf(image)), threshold));
  std::vector<Pair> pairs;
  for (const auto& c : components->All()) {
    const adit::detect::RunList runs = components->RunsOf(c);
    Pair& pair = pairs.emplace_back(Pair{MomentsOf(image, runs, {c.x_min_px, c.y_min_px}, threshold),
                                         cv::Mat::zeros(image.size(), CV_64F)});
    for (const Run& run : runs) {
      for (int x = run.begin_px; x < run.end_px; ++x) {
        pair.weights.at<double>(run.y_px, x) = ValueAt(image, x, run.y_px) - threshold;
        pair.peak_dn = std::max(pair.peak_dn, ValueAt(image, x, run.y_px));
      }
    }
  }
  return pairs;
}

/// Compares every component; returns how many of them had more than one pixel.
int Compare(const cv::Mat& image, int threshold) {
  int large = 0;
  for (const Pair& pair : PairsOf(image, threshold)) {
    const cv::Moments m = cv::moments(pair.weights);
    const Eigen::Vector2d centroid_px(m.m10 / m.m00, m.m01 / m.m00);
    CHECK((pair.moments.CentroidPx() - centroid_px).norm() < 1e-9);
    const double a = m.mu20 / m.m00 + 1.0 / 12, b = m.mu11 / m.m00, d = m.mu02 / m.m00 + 1.0 / 12;
    const Eigen::Vector2d sigmas_px = pair.moments.SigmasPx();
    // The eigenvalues of [a b; b d], by their sum and product.
    DOUBLES_EQUAL(a + d, sigmas_px.squaredNorm(), 1e-9 * (a + d));
    DOUBLES_EQUAL(a * d - b * b, std::pow(sigmas_px.x() * sigmas_px.y(), 2), 1e-8 * a * d);
    CHECK(sigmas_px.x() >= sigmas_px.y());
    const double area_px = cv::countNonZero(pair.weights);
    DOUBLES_EQUAL(m.m00 + area_px * (threshold - kNoise.background_dn), pair.moments.FluxDn(), 1e-6);
    DOUBLES_EQUAL(pair.peak_dn, pair.moments.PeakDn(), 0);
    large += area_px > 1;
  }
  return large;
}

cv::Mat Noise(int bits, unsigned seed) {
  cv::Mat image(60, 90, bits == 8 ? CV_8U : CV_16U);
  std::mt19937 random(seed);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const unsigned value = static_cast<unsigned>(random()) % (1U << bits);
      if (bits == 8) image.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(value);
      if (bits != 8) image.at<std::uint16_t>(y, x) = static_cast<std::uint16_t>(value);
    }
  }
  return image;
}

/// A spot that is longer along the diagonal, no two pixels alike.
cv::Mat Slanted() {
  cv::Mat image(24, 24, CV_8U, cv::Scalar(8));
  for (int y = 0; y < 24; ++y) {
    for (int x = 0; x < 24; ++x) {
      const double along = (x - 11.3 + y - 12.1) / std::sqrt(2),
                   across = (x - 11.3 - y + 12.1) / std::sqrt(2);
      const double light_dn = 8 + 180 * std::exp(-along * along / 18 - across * across / 6);
      image.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(std::lround(light_dn));
    }
  }
  return image;
}

}  // namespace

TEST_GROUP(SpotMoments){};

TEST(SpotMoments, EqualOpenCvsOnNoiseOfEightBits_Seeds1To4) {
  int large = 0;
  unsigned seed = 0;
  for (const int threshold : {120, 180, 215, 240}) large += Compare(Noise(8, ++seed), threshold);
  CHECK(large > 300);
}

TEST(SpotMoments, EqualOpenCvsOnNoiseOfTwelveBits_Seeds5To7) {
  int large = 0;
  unsigned seed = 4;
  for (const int threshold : {1900, 3000, 3700}) large += Compare(Noise(12, ++seed), threshold);
  CHECK(large > 200);
}

TEST(SpotMoments, DoNotDependOnTheirOriginOrTheOrderOfTheRuns) {
  constexpr int kThreshold = 20;
  const cv::Mat image = Slanted();
  Components components;
  CHECK(components.Segment(ViewOf(image), WholeOf(ViewOf(image)), kThreshold));
  LONGS_EQUAL(1, components.All().size());
  const adit::detect::RunList runs = components.RunsOf(components.All()[0]);
  std::vector<Run> backwards{Run{}};
  for (const Run& run : runs) {
    backwards.push_back(run);
    backwards.back().next = static_cast<std::uint32_t>(backwards.size() - 2);
  }
  CHECK(backwards.size() > 10);
  const SpotMoments near = MomentsOf(image, runs, {11, 12}, kThreshold);
  const SpotMoments far = MomentsOf(
      image, {backwards.data(), static_cast<std::uint32_t>(backwards.size() - 1)}, {-300, 700}, kThreshold);
  CHECK((near.CentroidPx() - far.CentroidPx()).norm() < 1e-9);
  CHECK((near.CovariancePx2() - far.CovariancePx2()).norm() < 1e-6 * near.CovariancePx2().norm());
  CHECK((near.SigmasPx() - far.SigmasPx()).norm() < 1e-6);
}

TEST(SpotMoments, CovarianceIsThePixelsNoiseThroughTheCentroidsDerivatives) {
  constexpr int kThreshold = 20;
  const cv::Mat image = Slanted();
  const auto pairs = PairsOf(image, kThreshold);
  LONGS_EQUAL(1, pairs.size());
  const cv::Mat& weights = pairs[0].weights;
  const auto centroid_px = [](const cv::Mat& w) {
    const cv::Moments m = cv::moments(w);
    return Eigen::Vector2d(m.m10 / m.m00, m.m01 / m.m00);
  };
  Eigen::Matrix2d numeric_px2 = Eigen::Matrix2d::Zero();
  constexpr double kStepDn = 1e-3;
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      if (weights.at<double>(y, x) == 0) continue;
      cv::Mat more = weights.clone(), less = weights.clone();
      more.at<double>(y, x) += kStepDn;
      less.at<double>(y, x) -= kStepDn;
      const Eigen::Vector2d slope = (centroid_px(more) - centroid_px(less)) / (2 * kStepDn);
      const double light_dn = ValueAt(image, x, y) - 8;
      numeric_px2 += slope * slope.transpose() * (1.5 * 1.5 + light_dn / 40 + 1.0 / 12);
    }
  }
  const Eigen::Matrix2d stated_px2 = pairs[0].moments.CovariancePx2();
  // What the cut-off adds is the same along both axes and never negative.
  DOUBLES_EQUAL(numeric_px2(0, 1), stated_px2(0, 1), 1e-6 * numeric_px2(0, 0));
  CHECK(stated_px2(0, 1) > 0.1 * stated_px2(0, 0));
  const Eigen::Matrix2d rest_px2 = stated_px2 - numeric_px2;
  CHECK(rest_px2(0, 0) >= 0);
  DOUBLES_EQUAL(rest_px2(0, 0), rest_px2(1, 1), 1e-6 * numeric_px2(0, 0));
  CHECK(rest_px2(0, 0) < numeric_px2(0, 0));
}
