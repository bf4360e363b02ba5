#include "host/coverage.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <sstream>

namespace adit::host {

void CoverageMap::Add(std::span<const Eigen::Vector2d> corners_px) {
  const auto cell = [](double place_px, int size_px, int cells) {
    return std::clamp(static_cast<int>(std::floor((place_px + 0.5) * cells / size_px)), 0, cells - 1);
  };
  const Eigen::Vector2d middle_px((width_px_ - 1) / 2.0, (height_px_ - 1) / 2.0);
  for (const Eigen::Vector2d& corner_px : corners_px) {
    const int column = cell(corner_px.x(), width_px_, kColumns), row = cell(corner_px.y(), height_px_, kRows);
    ++counts_[static_cast<std::size_t>(row * kColumns + column)];
    reach_ = std::max(reach_, (corner_px - middle_px).norm() / middle_px.norm());
  }
}

double CoverageMap::Pct() const {
  return 100.0 *
         static_cast<double>(counts_.size() -
                             static_cast<std::size_t>(std::count(counts_.begin(), counts_.end(), 0))) /
         static_cast<double>(counts_.size());
}

std::vector<std::string> CoverageMap::MissedCorners() const {
  std::vector<std::string> missed;
  for (const bool lower : {false, true}) {
    for (const bool right : {false, true}) {
      if (Count(right ? kColumns - 1 : 0, lower ? kRows - 1 : 0) == 0)
        missed.push_back(std::string(lower ? "lower " : "upper ") + (right ? "right" : "left"));
    }
  }
  return missed;
}

std::string CoverageMap::Text() const {
  std::ostringstream text;
  for (int row = 0; row < kRows; ++row) {
    text << "         ";
    for (int column = 0; column < kColumns; ++column) {
      text << std::setw(5);
      if (Count(column, row) == 0) {
        text << ".";
      } else {
        text << Count(column, row);
      }
    }
    text << "\n";
  }
  return text.str();
}

std::vector<unsigned char> DrawCoverage(const CoverageMap& map, std::span<const CoverageMark> marks,
                                        const Eigen::Vector2i& size_px, double sigma0_px) {
  const cv::Scalar background(32, 32, 32), missed(40, 40, 110), line(80, 80, 80);
  const cv::Scalar green(90, 200, 90), yellow(60, 210, 230), red(70, 70, 240);
  cv::Mat picture(size_px.y(), size_px.x(), CV_8UC3, background);
  for (int row = 0; row < CoverageMap::kRows; ++row) {
    for (int column = 0; column < CoverageMap::kColumns; ++column) {
      const cv::Point from(column * size_px.x() / CoverageMap::kColumns,
                           row * size_px.y() / CoverageMap::kRows);
      const cv::Point to((column + 1) * size_px.x() / CoverageMap::kColumns,
                         (row + 1) * size_px.y() / CoverageMap::kRows);
      if (map.Count(column, row) == 0) cv::rectangle(picture, from, to, missed, cv::FILLED);
      cv::rectangle(picture, from, to, line);
    }
  }
  constexpr double kEnlarged = 50;
  for (const CoverageMark& mark : marks) {
    const double share = mark.residual_px.norm() / (std::sqrt(2.0) * sigma0_px);
    const cv::Scalar& colour = share <= 1 ? green : share <= 2 ? yellow : red;
    const Eigen::Vector2d end_px = mark.image_px + kEnlarged * mark.residual_px;
    const cv::Point place(cv::Point2d(mark.image_px.x(), mark.image_px.y()));
    cv::line(picture, place, cv::Point(cv::Point2d(end_px.x(), end_px.y())), colour, 1, cv::LINE_AA);
    cv::circle(picture, place, std::max(1, size_px.x() / 400), colour, cv::FILLED, cv::LINE_AA);
  }
  std::vector<unsigned char> bytes;
  cv::imencode(".png", picture, bytes);
  return bytes;
}

}  // namespace adit::host
