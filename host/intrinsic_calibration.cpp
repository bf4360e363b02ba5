#include "host/intrinsic_calibration.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iomanip>
#include <map>
#include <sstream>

#include "host/intrinsics_uncertainty.h"

namespace adit::host {
namespace {

using base::Error;
using base::ErrorCode;

constexpr double kRobustPx = 1;        // corners of a sharp image err by 0.05 to 0.3 px
constexpr double kSamePosePx = 1;      // rms shift of the corners; a hand does not hold this still
constexpr double kImageMedianMax = 3;  // times the median of all: blur within one series gives up to 2
constexpr double kCornerSigmaMax = 5;  // of a corner's distance: 4 in a million right ones are farther out
constexpr double kFinestPx = 0.01;     // no corner is found better; exact test images have no residual at all
constexpr double kResidualMaxPx = 1;
constexpr double kDisagreementSigma = 0.5;
constexpr double kMedianPerSigma = 1.1774;  // of the length of a plane normal vector (Rayleigh): sqrt(2 ln 2)

std::string Digits(double value, int digits) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(digits) << value;
  return text.str();
}

double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::vector<double> Lengths(const std::vector<Eigen::Vector2d>& residuals_px) {
  std::vector<double> lengths;
  for (const Eigen::Vector2d& residual_px : residuals_px) lengths.push_back(residual_px.norm());
  return lengths;
}

/// The views without fault, and which of all they are.
struct Usable {
  std::vector<BoardView> views;
  std::vector<std::size_t> places;
};

Usable WithoutFault(const std::vector<BoardView>& views) {
  Usable usable;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (!views[i].fault.empty()) continue;
    usable.views.push_back(views[i]);
    usable.places.push_back(i);
  }
  return usable;
}

/// Whether two views hold the board in one place; they then repeat one another's errors.
bool SamePose(const BoardView& a, const BoardView& b) {
  std::size_t common = 0;
  double sum_px2 = 0;
  for (auto i = a.corners.begin(), k = b.corners.begin(); i != a.corners.end() && k != b.corners.end();) {
    if (i->id == k->id) {
      sum_px2 += (i++->image_px - k++->image_px).squaredNorm();
      ++common;
    } else {
      (i->id < k->id ? i : k)++;
    }
  }
  return common >= kBoardCornersMin && sum_px2 < kSamePosePx * kSamePosePx * static_cast<double>(common);
}

void MarkRepeated(std::vector<BoardView>& views) {
  for (std::size_t i = 0; i < views.size(); ++i) {
    for (std::size_t k = 0; k < i && views[i].fault.empty(); ++k) {
      if (views[k].fault.empty() && SamePose(views[k], views[i]))
        views[i].fault = "the board stands where it stands in " + views[k].image;
    }
  }
}

/// "3 of 7 images can be used (4: no board found); at least 5 are needed"; empty if they suffice.
std::string TooFewImages(const std::vector<BoardView>& views) {
  std::map<std::string, int> reasons;
  std::size_t used = 0;
  for (const BoardView& view : views) {
    if (view.fault.empty()) {
      ++used;
    } else {
      ++reasons[view.fault];
    }
  }
  if (used >= kBoardImagesMin) return "";
  std::string text = std::to_string(used) + " of " + std::to_string(views.size()) + " images can be used";
  std::string separator = " (";
  for (const auto& [reason, count] : reasons) {
    text += separator + std::to_string(count) + ": " + reason;
    separator = "; ";
  }
  if (!reasons.empty()) text += ")";
  return text + "; at least " + std::to_string(kBoardImagesMin) + " are needed";
}

/// Marks the images whose corners miss far more than those of all; whether there were any.
bool MarkOutliers(std::vector<BoardView>& views, const Usable& usable, const IntrinsicsBundle& bundle) {
  std::vector<double> medians_px;
  for (const auto& residuals_px : bundle.residuals_px) medians_px.push_back(Median(Lengths(residuals_px)));
  const double typical_px = std::max(Median(medians_px), kFinestPx);
  bool any = false;
  for (std::size_t i = 0; i < medians_px.size(); ++i) {
    if (medians_px[i] <= kImageMedianMax * typical_px) continue;
    any = true;
    views[usable.places[i]].fault = "its corners miss by " + Digits(medians_px[i], 2) +
                                    " px, those of half the images by less than " + Digits(typical_px, 2) +
                                    " px (medians)";
  }
  return any;
}

/// Removes corners beyond 5 sigma of the robust solution; how many.
std::size_t RemoveOutlyingCorners(std::vector<BoardView>& views, const Usable& usable,
                                  const IntrinsicsBundle& bundle) {
  std::vector<double> all_px;
  for (const auto& residuals_px : bundle.residuals_px) {
    const std::vector<double> lengths = Lengths(residuals_px);
    all_px.insert(all_px.end(), lengths.begin(), lengths.end());
  }
  const double limit_px = kCornerSigmaMax * std::max(Median(all_px) / kMedianPerSigma, kFinestPx);
  std::size_t removed = 0;
  for (std::size_t i = 0; i < usable.views.size(); ++i) {
    BoardView& view = views[usable.places[i]];
    std::vector<BoardCorner> kept;
    for (std::size_t k = 0; k < view.corners.size(); ++k) {
      if (bundle.residuals_px[i][k].norm() <= limit_px) kept.push_back(view.corners[k]);
    }
    removed += view.corners.size() - kept.size();
    if (2 * kept.size() < view.corners.size() || kept.size() < kBoardCornersMin) {
      view.fault = std::to_string(view.corners.size() - kept.size()) + " of " +
                   std::to_string(view.corners.size()) + " corners miss by more than " + Digits(limit_px, 2) +
                   " px";
    }
    view.corners = std::move(kept);
  }
  return removed;
}

void Warn(IntrinsicCalibration& out) {
  std::string missed;
  const CoverageMap coverage = out.Coverage();
  for (const std::string& corner : coverage.MissedCorners()) missed += (missed.empty() ? "" : ", ") + corner;
  if (!missed.empty()) {
    out.warnings.push_back("the board never reached the image's corner " + missed +
                           ": distortion is extrapolated there");
  }
  for (std::string& sentence : Uncertain(out.covariance, out.camera))
    out.warnings.push_back(std::move(sentence));
  if (out.dispersion > 1) {
    out.warnings.push_back("the images disagree " + Digits(out.dispersion, 1) +
                           " times as much as the corners' scatter explains (is the board flat?); sigma is "
                           "enlarged by that");
  }
  if (out.rms_px > kResidualMaxPx) {
    out.warnings.push_back("the corners miss by " + Digits(out.rms_px, 1) +
                           " px: is the board flat, and are its squares counted and measured right?");
  }
  if (!out.opencv) {
    out.warnings.push_back("OpenCV finds no solution for these corners");
    return;
  }
  const double exact = std::max(1.0, kFinestPx / out.sigma0_px);  // OpenCV rounds corners to 32 bit
  const IntrinsicVector apart =
      (Intrinsics(out.camera) - Intrinsics(out.opencv->camera)).cwiseAbs().cwiseQuotient(exact * out.Sigma());
  int worst = 0;
  if (apart.maxCoeff(&worst) > kDisagreementSigma) {
    out.warnings.push_back("OpenCV's solution differs by " + Digits(apart[worst], 1) + " sigma in " +
                           kIntrinsicNames[static_cast<std::size_t>(worst)]);
  }
}

/// The bundle's own figures, and one report an image.
IntrinsicCalibration Reported(const std::vector<BoardView>& views, const Usable& usable,
                              const IntrinsicsBundle& bundle) {
  IntrinsicCalibration out;
  out.camera = bundle.camera;
  for (const BoardView& view : views) out.images.push_back({view.image, view.corners.size(), 0, view.fault});
  double sum_px2 = 0;
  for (std::size_t i = 0; i < usable.views.size(); ++i) {
    const auto& residuals_px = bundle.residuals_px[i];
    double image_px2 = 0;
    for (std::size_t k = 0; k < residuals_px.size(); ++k) {
      image_px2 += residuals_px[k].squaredNorm();
      out.marks.push_back({usable.views[i].corners[k].image_px, residuals_px[k]});
    }
    out.images[usable.places[i]].rms_px = std::sqrt(image_px2 / static_cast<double>(residuals_px.size()));
    sum_px2 += image_px2;
  }
  out.corners = out.marks.size();
  out.rms_px = std::sqrt(sum_px2 / static_cast<double>(out.corners));
  // At least 5 images of 8 corners: 80 coordinates for 38 parameters.
  const auto freedom = static_cast<double>(2 * out.corners - kIntrinsics - 6 * usable.views.size());
  out.sigma0_px = std::sqrt(sum_px2 / freedom);
  return out;
}

/// The robust solution over the images that agree; marks those that do not.
base::Result<IntrinsicsBundle> AdjustRobustly(std::vector<BoardView>& views, const Eigen::Vector2i& size_px) {
  for (;;) {
    if (const std::string few = TooFewImages(views); !few.empty()) return Error{ErrorCode::kFailed, "", few};
    const Usable usable = WithoutFault(views);
    const auto start = StartIntrinsics(usable.views, size_px.x(), size_px.y());
    auto bundle =
        start ? AdjustIntrinsics(usable.views, start->camera, start->poses, kRobustPx) : std::nullopt;
    if (!bundle) {
      return Error{ErrorCode::kFailed, "",
                   "no camera fits the corners of the " + std::to_string(usable.views.size()) +
                       " images: are they of one camera with one focus and zoom?"};
    }
    if (!MarkOutliers(views, usable, *bundle)) return std::move(*bundle);
  }
}

}  // namespace

std::size_t IntrinsicCalibration::ImagesUsed() const {
  return static_cast<std::size_t>(std::count_if(
      images.begin(), images.end(), [](const ImageReport& image) { return image.left_out.empty(); }));
}

CoverageMap IntrinsicCalibration::Coverage() const {
  CoverageMap map(camera.width_px, camera.height_px);
  for (const CoverageMark& mark : marks) map.Add({&mark.image_px, 1});
  return map;
}

base::Result<IntrinsicCalibration> CalibrateIntrinsics(std::vector<BoardView> views, int width_px,
                                                       int height_px) {
  if (std::all_of(views.begin(), views.end(), [](const BoardView& view) { return view.corners.empty(); })) {
    return Error{ErrorCode::kUsage, "--board",
                 "is found in none of the " + std::to_string(views.size()) +
                     " images; it counts the corners inside the board, not its squares"};
  }
  MarkRepeated(views);
  const auto robust = AdjustRobustly(views, {width_px, height_px});
  if (!robust) return robust.error();
  const Usable agreeing = WithoutFault(views);
  const std::size_t removed = RemoveOutlyingCorners(views, agreeing, *robust);
  if (const std::string few = TooFewImages(views); !few.empty()) return Error{ErrorCode::kFailed, "", few};
  const Usable usable = WithoutFault(views);
  std::vector<BoardPose> poses;
  for (std::size_t i = 0; i < agreeing.places.size(); ++i) {
    if (views[agreeing.places[i]].fault.empty()) poses.push_back(robust->poses[i]);
  }
  const auto bundle = AdjustIntrinsics(usable.views, robust->camera, poses, std::nullopt);
  if (!bundle) return Error{ErrorCode::kFailed, "", "the adjustment does not converge to a camera"};
  IntrinsicCalibration out = Reported(views, usable, *bundle);
  const IntrinsicMatrix inverse = InverseInformation(*bundle);
  const double judged_px = std::max(out.sigma0_px, kFinestPx);
  if (const std::string open = Undetermined(judged_px * judged_px * inverse, out.camera); !open.empty())
    return Error{ErrorCode::kFailed, "", open};
  out.dispersion = ImageDispersion(*bundle, judged_px);
  out.covariance = std::pow(out.dispersion * out.sigma0_px, 2) * inverse;
  out.corners_left_out = removed;
  out.opencv = SolveByOpenCv(usable.views, width_px, height_px);
  Warn(out);
  return out;
}

}  // namespace adit::host
