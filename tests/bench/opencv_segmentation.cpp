#include "tests/bench/opencv_segmentation.h"

#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>

#include "tests/bench/bench_frames.h"

namespace adit::bench {
namespace {

constexpr double kThresholdDn = 30;
constexpr int kAreaMinPx = 4, kAreaMaxPx = 1200;

cv::Mat View(std::span<const std::uint8_t> pixels) {
  return {kHeightPx, kWidthPx, CV_8UC1, const_cast<std::uint8_t*>(pixels.data())};
}

}  // namespace

void KeepOpenCvOnOneCore() { cv::setNumThreads(1); }

std::size_t SegmentByContours(std::span<const std::uint8_t> pixels) {
  const cv::Mat image = View(pixels);
  static cv::Mat bright;
  cv::threshold(image, bright, kThresholdDn, 255, cv::THRESH_BINARY);
  static std::vector<std::vector<cv::Point>> contours;
  cv::findContours(bright, contours, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
  std::size_t spots = 0;
  double sink = 0;
  for (const auto& contour : contours) {
    const cv::Rect box = cv::boundingRect(contour);
    if (box.area() < kAreaMinPx || box.area() > kAreaMaxPx) continue;
    const cv::Moments m = cv::moments(image(box), false);
    sink += m.m10 / m.m00;
    ++spots;
  }
  return sink >= 0 ? spots : 0;
}

std::size_t SegmentByComponents(std::span<const std::uint8_t> pixels) {
  const cv::Mat image = View(pixels);
  static cv::Mat bright, labels, stats, centroids;
  cv::threshold(image, bright, kThresholdDn, 255, cv::THRESH_BINARY);
  const int count = cv::connectedComponentsWithStats(bright, labels, stats, centroids, 8, CV_32S);
  std::size_t spots = 0;
  double sink = 0;
  for (int i = 1; i < count; ++i) {
    const int area = stats.at<int>(i, cv::CC_STAT_AREA);
    if (area < kAreaMinPx || area > kAreaMaxPx) continue;
    const cv::Rect box(stats.at<int>(i, cv::CC_STAT_LEFT), stats.at<int>(i, cv::CC_STAT_TOP),
                       stats.at<int>(i, cv::CC_STAT_WIDTH), stats.at<int>(i, cv::CC_STAT_HEIGHT));
    const cv::Moments m = cv::moments(image(box), false);
    sink += m.m10 / m.m00;
    ++spots;
  }
  return sink >= 0 ? spots : 0;
}

}  // namespace adit::bench
