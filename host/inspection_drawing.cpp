#include "host/inspection_drawing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iomanip>
#include <opencv2/imgproc.hpp>
#include <sstream>

namespace adit::host {
namespace {

using base::kLedCount;
using base::Side;
using Eigen::Vector2d;

const cv::Scalar kWhite(235, 235, 235), kGrey(150, 150, 150), kRed(70, 70, 255), kOrange(60, 150, 255),
    kPanel(38, 34, 30);
const std::array<cv::Scalar, 6> kTargetColours{cv::Scalar(120, 230, 90),  cv::Scalar(255, 190, 60),
                                               cv::Scalar(200, 110, 255), cv::Scalar(70, 220, 255),
                                               cv::Scalar(230, 230, 90),  cv::Scalar(170, 170, 255)};
constexpr int kLine = 24, kMargin = 16;   // px of text
constexpr int kTile = 400, kZoomMax = 8;  // px of an enlargement
constexpr int kShift = 4;                 // drawing is exact to a sixteenth of a pixel

const cv::Scalar& ColourOf(std::size_t target) { return kTargetColours[target % kTargetColours.size()]; }

cv::Point Exact(const Vector2d& px, double scale = 1) {
  const auto at = [scale](double v) {
    return static_cast<int>(std::lround((v + 0.5) * scale * (1 << kShift)));
  };
  return {at(px.x()), at(px.y())};
}

void PutText(cv::Mat& out, const std::string& text, cv::Point at, const cv::Scalar& colour,
             double size = 0.55) {
  cv::putText(out, text, at, cv::FONT_HERSHEY_SIMPLEX, size, colour, 1, cv::LINE_AA);
}

/// Where the bright part begins is what matters: the root makes faint things show.
cv::Mat Brightened(const base::ImageView& image) {
  const cv::Mat pixels(image.height_px, image.width_px, image.bits > 8 ? CV_16U : CV_8U,
                       const_cast<std::uint8_t*>(image.data), static_cast<std::size_t>(image.stride_bytes));
  cv::Mat share, grey, colour;
  pixels.convertTo(share, CV_32F, 1.0 / ((1 << image.bits) - 1));
  cv::sqrt(share, share);
  share.convertTo(grey, CV_8U, 255);
  cv::cvtColor(grey, colour, cv::COLOR_GRAY2BGR);
  return colour;
}

/// One image with its marks, at a scale and from a corner: the overview and the enlargements.
class Marks {
 public:
  Marks(const Inspection& inspection, const DrawingOrder& order, Side side)
      : inspection_(inspection), order_(order), side_(side), i_(static_cast<std::size_t>(side)) {}

  void Draw(cv::Mat& out, const Vector2d& corner_px, double scale) const {
    DrawSpots(out, corner_px, scale);
    for (std::size_t k = 0; k < inspection_.candidates.size(); ++k) DrawCandidate(k, out, corner_px, scale);
    for (const auto& target : inspection_.result->points.targets) DrawTarget(target, out, corner_px, scale);
  }

 private:
  const optics::CameraModel& Camera() const {
    return side_ == Side::kLeft ? order_.rig->left : order_.rig->right;
  }
  const detect::BlobSet& Blobs() const { return (*inspection_.blobs)[i_]; }

  void DrawSpots(cv::Mat& out, const Vector2d& corner_px, double scale) const {
    for (const detect::Blob& blob : Blobs().blobs) {
      const double half_px = 0.5 * std::max(blob.x_max_px - blob.x_min_px, blob.y_max_px - blob.y_min_px) + 2;
      cv::circle(out, Exact(blob.raw_px - corner_px, scale),
                 static_cast<int>(half_px * scale * (1 << kShift)), kGrey, 1, cv::LINE_AA, kShift);
    }
    constexpr std::array<const char*, 4> kLetters{"s", "l", "o", "b"};
    for (const RejectedSpot& spot : inspection_.rejected[i_]) {
      const Vector2d at_px = spot.raw_px - corner_px;
      const double arm_px = std::max(4 / scale, 0.7 * spot.half_px);
      for (const double slope : {-1.0, 1.0})
        cv::line(out, Exact(at_px - arm_px * Vector2d(1, slope), scale),
                 Exact(at_px + arm_px * Vector2d(1, slope), scale), kRed, 1, cv::LINE_AA, kShift);
      const cv::Point text = Exact(at_px + Vector2d(arm_px, -arm_px), scale) / (1 << kShift);
      PutText(out, kLetters[static_cast<std::size_t>(spot.why)], text, kRed, 0.4);
    }
  }

  void DrawCandidate(std::size_t k, cv::Mat& out, const Vector2d& corner_px, double scale) const {
    const InspectedCandidate& candidate = inspection_.candidates[k];
    const cv::Scalar& colour = candidate.taken ? ColourOf(candidate.sighting.target) : kOrange;
    if (side_ == Side::kRight) {
      for (const std::uint16_t blob : candidate.sighting.blobs)
        DrawEpipolarLine(blob, colour, out, corner_px, scale);
      return;
    }
    const auto& blobs = Blobs().blobs;
    const Vector2d first_px = blobs[candidate.sighting.blobs[0]].raw_px - corner_px;
    const Vector2d last_px = blobs[candidate.sighting.blobs[3]].raw_px - corner_px;
    cv::line(out, Exact(first_px, scale), Exact(last_px, scale), colour, 1, cv::LINE_AA, kShift);
    const cv::Point text = Exact(first_px, scale) / (1 << kShift) + cv::Point(-26, -10);
    if (!candidate.taken) PutText(out, "#" + std::to_string(k + 1), text, kOrange, 0.5);
  }

  /// Through the lens: a straight line of the ideal image, bent as the camera bends it.
  void DrawEpipolarLine(std::uint16_t left_blob, const cv::Scalar& colour, cv::Mat& out,
                        const Vector2d& corner_px, double scale) const {
    constexpr double kStepPx = 20;
    const Vector2d& ideal_px = (*inspection_.blobs)[0].blobs[left_blob].ideal_px;
    const Eigen::Vector3d line = order_.rig->Fundamental() * ideal_px.homogeneous();
    if (std::abs(line.y()) < std::abs(line.x())) return;  // upright: no rig of adit has such
    std::vector<cv::Point> points;
    for (double x = 0; x <= Camera().width_px; x += kStepPx) {
      const Vector2d on_line_px(x, -(line.x() * x + line.z()) / line.y());
      points.push_back(
          Exact(Camera().Pixel(Camera().Distort(Camera().Normalised(on_line_px))) - corner_px, scale));
    }
    cv::polylines(out, points, false, 0.6 * colour, 1, cv::LINE_AA, kShift);
  }

  void DrawTarget(const stereo::TargetPoints& target, cv::Mat& out, const Vector2d& corner_px,
                  double scale) const {
    if (target.status == stereo::FixStatus::kLost) return;
    const cv::Scalar& colour = ColourOf(target.target);
    const auto& blobs = Blobs().blobs;
    for (std::size_t led = 0; led < kLedCount; ++led) {
      const std::uint16_t blob = target.blobs[i_][led];
      const bool measured = blob < blobs.size();
      const auto projected = Camera().Project(
          side_ == Side::kLeft ? target.leds_b_m[led] : order_.rig->T_r_l * target.leds_b_m[led]);
      if (!measured && !projected) continue;
      const Vector2d at_px = (measured ? blobs[blob].raw_px : *projected) - corner_px;
      const cv::Point centre = Exact(at_px, scale);
      const int radius = (measured ? 9 : 12) << kShift;
      cv::circle(out, centre, radius, colour, measured ? 2 : 1, cv::LINE_AA, kShift);
      PutText(out, std::to_string(led + 1) + (measured ? "" : " rebuilt"),
              centre / (1 << kShift) + cv::Point(8, -12), colour, 0.5);
    }
  }

  const Inspection& inspection_;
  const DrawingOrder& order_;
  Side side_;
  std::size_t i_;
};

/// The part of an image that holds a target or its best candidate, in raw pixels; empty if there is none.
cv::Rect2d PlaceOf(const Inspection& inspection, const DrawingOrder& order, std::size_t target, Side side) {
  const stereo::TargetPoints& located = inspection.result->points.targets[target];
  const optics::CameraModel& camera = side == Side::kLeft ? order.rig->left : order.rig->right;
  std::vector<Vector2d> places_px;
  if (located.status != stereo::FixStatus::kLost) {
    for (const Eigen::Vector3d& led_m : located.leds_b_m) {
      const auto px = camera.Project(side == Side::kLeft ? led_m : order.rig->T_r_l * led_m);
      if (px) places_px.push_back(*px);
    }
  } else if (side == Side::kLeft) {
    for (const InspectedCandidate& candidate : inspection.candidates) {
      if (candidate.sighting.target != target || !places_px.empty()) continue;
      for (const std::uint16_t blob : candidate.sighting.blobs)
        places_px.push_back((*inspection.blobs)[0].blobs[blob].raw_px);
    }
  }
  if (places_px.empty()) return {};
  Vector2d low = places_px[0], high = places_px[0];
  for (const Vector2d& px : places_px) low = low.cwiseMin(px), high = high.cwiseMax(px);
  constexpr double kAroundPx = 12;
  const double size =
      std::max((high - low).maxCoeff() + 2 * kAroundPx, kTile / static_cast<double>(kZoomMax));
  const Vector2d corner = 0.5 * (low + high) - Vector2d::Constant(size / 2);
  return {corner.x(), corner.y(), size, size};
}

std::vector<std::string> LinesOf(const stereo::TargetPoints& target, const std::string& name) {
  std::ostringstream place, more;
  place << std::fixed << std::setprecision(3);
  if (target.status == stereo::FixStatus::kLost) return {name + ": LOST", Explain(target.reason)};
  const Eigen::Vector3d sigma_m = target.epicenter_covariance_m2.diagonal().cwiseSqrt();
  place << "x " << target.epicenter_b_m.x() << "  y " << target.epicenter_b_m.y() << "  z "
        << target.epicenter_b_m.z() << " m  +- " << std::setprecision(2) << 1e3 * sigma_m.x() << " / "
        << 1e3 * sigma_m.y() << " / " << 1e3 * sigma_m.z() << " mm";
  more << std::fixed << std::setprecision(4) << "bar " << target.bar_m << " m, reprojection "
       << std::setprecision(3) << target.reprojection_px << " px";
  std::string status = name + ": tracked";
  if (target.status == stereo::FixStatus::kPredicted) status = name + ": predicted";
  if (target.status == stereo::FixStatus::kRecovered) {
    status = name + ": recovered, rebuilt LED";
    for (std::size_t led = 0; led < kLedCount; ++led) {
      if ((target.recovered_mask >> led & 1) != 0) status += " " + std::to_string(led + 1);
    }
  }
  return {status, place.str(), more.str()};
}

/// One row of the panel: a target's words and its enlargements.
cv::Mat DrawTargetRow(const std::array<cv::Mat, 2>& images, const Inspection& inspection,
                      const DrawingOrder& order, std::size_t target) {
  constexpr int kWordsHigh = 4 * kLine;
  cv::Mat all(kWordsHigh + kTile + kMargin, 2 * kTile + 3 * kMargin, CV_8UC3, kPanel);
  int y = kLine;
  for (const std::string& line : LinesOf(inspection.result->points.targets[target], order.names[target])) {
    PutText(all, line, {kMargin, y}, y == kLine ? ColourOf(target) : kWhite);
    y += kLine;
  }
  for (const Side side : {Side::kLeft, Side::kRight}) {
    const auto i = static_cast<std::size_t>(side);
    const cv::Rect tile(kMargin + static_cast<int>(i) * (kTile + kMargin), kWordsHigh, kTile, kTile);
    cv::Mat part = all(tile);
    part.setTo(cv::Scalar(20, 18, 16));
    const cv::Rect2d place = PlaceOf(inspection, order, target, side);
    if (place.empty()) {
      PutText(part, side == Side::kLeft ? "no candidate" : "not found", {kMargin, kTile / 2}, kGrey);
      continue;
    }
    const double scale = kTile / place.width;
    const cv::Matx23d map(scale, 0, -place.x * scale + (scale - 1) / 2, 0, scale,
                          -place.y * scale + (scale - 1) / 2);
    cv::warpAffine(images[i], part, map, part.size(), cv::INTER_NEAREST);
    Marks(inspection, order, side).Draw(part, {place.x, place.y}, scale);
    std::ostringstream caption;
    caption << (side == Side::kLeft ? "left" : "right") << ", " << std::fixed << std::setprecision(1) << scale
            << " x";
    PutText(part, caption.str(), {8, kTile - 10}, kWhite, 0.45);
  }
  return all;
}

cv::Mat DrawLegend(const Inspection& inspection, const DrawingOrder& order, int width_px, int height_px) {
  cv::Mat panel(height_px, width_px, CV_8UC3, kPanel);
  int y = 0;
  const auto line = [&](const std::string& text, const cv::Scalar& colour) {
    PutText(panel, text, {kMargin, y += kLine}, colour);
  };
  line(order.title, kWhite);
  for (const std::size_t side : {0U, 1U}) {
    const detect::BlobSet& set = (*inspection.blobs)[side];
    std::ostringstream text;
    text << (side == 0 ? "left: " : "right: ") << set.blobs.size() << " blobs above " << std::fixed
         << std::setprecision(0) << set.threshold_dn << " DN; rejected: " << set.rejects.too_small
         << " small, " << set.rejects.too_large << " large, " << set.rejects.not_round << " not round, "
         << set.rejects.at_border << " at the border";
    line(text.str(), kWhite);
  }
  line("O  LED of a target, with its number, in the target's colour", ColourOf(0));
  line("o  blob: could be an LED, belongs to no target", kGrey);
  line("x  bright, but no LED:  s small   l large   o not round   b at the border", kRed);
  line("-- four blobs on a line that pass for a target (#: rejected);  right: epipolar lines", kOrange);
  y += kLine / 2;
  line(std::to_string(inspection.candidates.size()) + " candidates in the left image", kWhite);
  for (std::size_t k = 0; k < inspection.candidates.size(); ++k) {
    const InspectedCandidate& candidate = inspection.candidates[k];
    if (y + 2 * kLine > height_px) {
      line("... and " + std::to_string(inspection.candidates.size() - k) + " more", kWhite);
      break;
    }
    std::ostringstream text;
    text << "#" << k + 1 << " " << order.names[candidate.sighting.target] << std::fixed
         << std::setprecision(4) << " p2 " << candidate.sighting.p2 << ", " << std::setprecision(1)
         << candidate.sighting.length_px << " px, " << candidate.verdict;
    line(text.str(), candidate.taken ? ColourOf(candidate.sighting.target) : kOrange);
  }
  return panel;
}

}  // namespace

cv::Mat DrawInspection(const ImagePair& pair, const Inspection& inspection, const DrawingOrder& order) {
  std::array<cv::Mat, 2> plain, marked;
  for (const Side side : {Side::kLeft, Side::kRight}) {
    const auto i = static_cast<std::size_t>(side);
    plain[i] = Brightened(pair.Frame(side).image);
    marked[i] = plain[i].clone();
    Marks(inspection, order, side).Draw(marked[i], Vector2d::Zero(), 1);
    PutText(marked[i], side == Side::kLeft ? "left" : "right", {kMargin, 2 * kLine}, kWhite, 1);
  }
  cv::Mat images, panel;
  cv::hconcat(marked[0], marked[1], images);
  std::vector<cv::Mat> rows;
  for (std::size_t target = 0; target < order.names.size(); ++target)
    rows.push_back(DrawTargetRow(plain, inspection, order, target));
  // Words at the left, then the targets, as many in a line as the images are wide.
  constexpr int kWordsPx = 1000;
  const int width_px = std::max(images.cols, kWordsPx + rows[0].cols);
  const auto across = static_cast<std::size_t>((width_px - kWordsPx) / rows[0].cols);
  const std::size_t lines = (rows.size() + across - 1) / across;
  cv::Mat out(images.rows + static_cast<int>(lines) * rows[0].rows, width_px, CV_8UC3, kPanel);
  images.copyTo(out(cv::Rect(0, 0, images.cols, images.rows)));
  DrawLegend(inspection, order, kWordsPx, out.rows - images.rows)
      .copyTo(out(cv::Rect(0, images.rows, kWordsPx, out.rows - images.rows)));
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const cv::Point corner(kWordsPx + static_cast<int>(k % across) * rows[k].cols,
                           images.rows + static_cast<int>(k / across) * rows[k].rows);
    rows[k].copyTo(out(cv::Rect(corner, rows[k].size())));
  }
  return out;
}

}  // namespace adit::host
