#include "host/intrinsics_text.h"

#include <algorithm>
#include <iomanip>
#include <sstream>

#include "firmware/optics/rig.h"

namespace adit::host {
namespace {

void WriteImages(const IntrinsicCalibration& c, std::ostream& text) {
  std::size_t longest = 0;
  for (const ImageReport& image : c.images) longest = std::max(longest, image.image.size());
  for (const ImageReport& image : c.images) {
    text << "  " << std::left << std::setw(static_cast<int>(longest)) << image.image << std::right << "  ";
    if (image.left_out.empty()) {
      text << std::setw(4) << image.corners << " corners  " << std::fixed << std::setprecision(3)
           << image.rms_px << " px rms\n";
    } else {
      text << "left out: " << image.left_out << "\n";
    }
  }
}

void WriteParameters(const IntrinsicCalibration& c, std::ostream& text) {
  const IntrinsicVector value = Intrinsics(c.camera), sigma = c.Sigma();
  text << "                   value       sigma" << (c.opencv ? "      OpenCV  its sigma  apart by\n" : "\n");
  for (int i = 0; i < kIntrinsics; ++i) {
    const int digits = i < 4 ? 3 : 6;  // pixels, or distortion coefficients
    text << "  " << kIntrinsicNames[static_cast<std::size_t>(i)] << (i < 4 ? " px" : "   ") << std::fixed
         << std::setprecision(digits) << std::setw(17) << value[i] << std::setw(12) << sigma[i];
    if (c.opencv) {
      const double theirs = Intrinsics(c.opencv->camera)[i];
      text << std::setw(12) << theirs << std::setw(11) << c.opencv->sigma[i] << std::setprecision(3)
           << std::setw(8) << (value[i] - theirs) / sigma[i] << " sigma";
    }
    text << "\n";
  }
}

}  // namespace

std::string FormatIntrinsics(const IntrinsicCalibration& c) {
  std::ostringstream text;
  text << optics::FormatCamera(c.camera) << std::setprecision(9);
  const auto row = [&text](const auto& values) {
    text << "[";
    for (Eigen::Index i = 0; i < kIntrinsics; ++i) text << (i == 0 ? "" : ", ") << values[i];
    text << "]";
  };
  text << "sigma: ";
  row(c.Sigma());
  text << "  # of fu, fv, cu, cv in px, k1, k2, p1, p2\ncovariance:  # of the same\n";
  for (Eigen::Index r = 0; r < kIntrinsics; ++r) {
    text << "  - ";
    row(c.covariance.row(r));
    text << "\n";
  }
  text << std::setprecision(6) << "quality:\n  images_seen: " << c.images.size()
       << "\n  images_used: " << c.ImagesUsed() << "\n  corners_used: " << c.corners
       << "\n  corners_left_out: " << c.corners_left_out << "\n  rms_px: " << c.rms_px
       << "\n  sigma0_px: " << c.sigma0_px << "\n  dispersion: " << c.dispersion
       << "\n  coverage_pct: " << c.Coverage().Pct()
       << "  # of 8 x 6 cells\n  reach_pct: " << 100 * c.Coverage().Reach() << "  # of half the diagonal\n";
  return text.str();
}

std::string Summary(const IntrinsicCalibration& c, const Board& board) {
  std::ostringstream text;
  text << "board    " << board.Text() << "\nimages   " << c.ImagesUsed() << " of " << c.images.size()
       << " used, " << c.corners << " corners, " << c.corners_left_out << " more left out beyond 5 sigma\n";
  WriteImages(c, text);
  text << "residual " << std::fixed << std::setprecision(3) << c.rms_px << " px rms a corner";
  if (c.opencv) text << ", OpenCV's " << c.opencv->rms_px << " px";
  text << "; a coordinate's standard deviation is " << c.sigma0_px << " px\n";
  WriteParameters(c, text);
  const CoverageMap coverage = c.Coverage();
  text << std::setprecision(0) << "coverage " << coverage.Pct() << " % of 8 x 6 cells, out to "
       << 100 * coverage.Reach() << " % of half the diagonal; corners a cell:\n"
       << coverage.Text();
  text << "verdict  " << (c.warnings.empty() ? "good" : "usable, but:") << "\n";
  for (const std::string& warning : c.warnings) text << "  " << warning << "\n";
  return text.str();
}

}  // namespace adit::host
