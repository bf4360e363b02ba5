#include "firmware/detect/detector.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "firmware/detect/background.h"
#include "firmware/detect/centroid.h"
#include "firmware/detect/components.h"

namespace adit::detect {
namespace {

// A pixel is bright above background + kSigmas * noise: of 1.4 million Gaussian pixels 0.0014 do so by
// chance.
constexpr double kSigmas = 6;
// and never nearer than this to the background, at 8 bit: uneven veils and glare stay dark, and the weight I
// - T is within 1.2 of the bound for peaks from 50 DN on (bounds simulated for T = 12 to 30).
constexpr double kLeastContrastDn = 12;
constexpr std::uint32_t kDropped = UINT32_MAX;

}  // namespace

struct Detector::State {
  optics::CameraModel camera;
  DetectorOptions options;
  Components components;
  std::vector<std::uint32_t> spot_of;  ///< component -> spot, or kDropped
  std::vector<SpotMoments> spots;
  std::vector<std::uint32_t> component_of_spot;

  State(const optics::CameraModel& model, const DetectorOptions& given) : camera(model), options(given) {
    spot_of.resize(Components::kMaxRuns);
    spots.reserve(kMaxBlobs);
    component_of_spot.reserve(kMaxBlobs);
  }

  void Choose(const base::ImageView& image, const PixelNoise& noise, BlobSet& out);
  void Measure(const base::ImageView& image);
  void Emit(const base::ImageView& image, BlobSet& out);
};

Detector::Detector(const optics::CameraModel& camera, const DetectorOptions& options)
    : state_(std::make_unique<State>(camera, options)) {}
Detector::~Detector() = default;
Detector::Detector(Detector&&) noexcept = default;
Detector& Detector::operator=(Detector&&) noexcept = default;

void Detector::State::Choose(const base::ImageView& image, const PixelNoise& noise, BlobSet& out) {
  spots.clear();
  component_of_spot.clear();
  // A round spot is not much longer than the circle of its area; what is thrice as long goes without a look
  // at its pixels.
  constexpr double kBoxSlack = 3;
  const auto all = components.All();
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Component& c = all[i];
    spot_of[i] = kDropped;
    const int width = c.x_max_px - c.x_min_px + 1, height = c.y_max_px - c.y_min_px + 1;
    const double round_px = std::sqrt(4 / M_PI * c.area_px);
    if (c.area_px < options.area_min_px) {
      ++out.rejects.too_small;
    } else if (c.area_px > options.area_max_px) {
      ++out.rejects.too_large;
    } else if (c.x_min_px == 0 || c.y_min_px == 0 || c.x_max_px == image.width_px - 1 ||
               c.y_max_px == image.height_px - 1) {
      ++out.rejects.at_border;
    } else if (std::max(width, height) > kBoxSlack * options.elongation_max * round_px) {
      ++out.rejects.not_round;
    } else if (spots.size() == kMaxBlobs) {
      ++out.rejects.no_room;
    } else {
      spot_of[i] = static_cast<std::uint32_t>(spots.size());
      component_of_spot.push_back(static_cast<std::uint32_t>(i));
      spots.emplace_back(Eigen::Vector2d(0.5 * (c.x_min_px + c.x_max_px), 0.5 * (c.y_min_px + c.y_max_px)),
                         static_cast<double>(out.threshold_dn), noise);
    }
  }
}

void Detector::State::Measure(const base::ImageView& image) {
  const auto runs = components.Runs();
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const std::uint32_t spot = spot_of[components.ComponentOf(i)];
    if (spot != kDropped) spots[spot].Take(image, runs[i]);
  }
}

void Detector::State::Emit(const base::ImageView& image, BlobSet& out) {
  const double full_scale_dn = (1 << image.bits) - 1;
  for (std::size_t i = 0; i < spots.size(); ++i) {
    const SpotMoments& spot = spots[i];
    const Component& component = components.All()[component_of_spot[i]];
    const Eigen::Vector2d sigmas_px = spot.SigmasPx();
    Eigen::Matrix2d slope;
    const auto ideal_px = camera.Undistort(spot.CentroidPx(), &slope);
    if (!(sigmas_px.x() <= options.elongation_max * sigmas_px.y()) || !ideal_px) {
      ++out.rejects.not_round;
      continue;
    }
    Blob blob;
    blob.raw_px = spot.CentroidPx();
    blob.ideal_px = *ideal_px;
    blob.covariance_px2 = slope * spot.CovariancePx2() * slope.transpose();
    blob.flux_dn = static_cast<float>(spot.FluxDn());
    blob.peak_dn = static_cast<float>(spot.PeakDn());
    blob.background_dn = out.background_dn;
    blob.area_px = static_cast<float>(component.area_px);
    blob.sigma_major_px = static_cast<float>(sigmas_px.x());
    blob.sigma_minor_px = static_cast<float>(sigmas_px.y());
    blob.x_min_px = component.x_min_px, blob.y_min_px = component.y_min_px;
    blob.x_max_px = component.x_max_px, blob.y_max_px = component.y_max_px;
    blob.saturated = spot.PeakDn() >= full_scale_dn;
    out.blobs.push_back(blob);
  }
}

void Detector::Detect(const base::CameraFrame& frame, BlobSet& out) {
  const base::ImageView& image = frame.image;
  out.stamp = frame.stamp;
  out.blobs.clear();
  out.rejects = {};
  out.background_dn = out.noise_dn = out.threshold_dn = 0;
  if (out.stamp.status != base::FrameStatus::kOk) return;
  if (image.bits < 8 || image.bits > 12) {
    out.stamp.status = base::FrameStatus::kWrongFormat;
    return;
  }
  if (image.data == nullptr || image.width_px != state_->camera.width_px ||
      image.height_px != state_->camera.height_px ||
      image.stride_bytes < std::ptrdiff_t{image.width_px} * image.BytesPerPixel()) {
    out.stamp.status = base::FrameStatus::kWrongSize;
    return;
  }
  const double scale = 1 << (image.bits - 8);  // DN of this image per DN at 8 bit
  const Background background = EstimateBackground(image);
  const double contrast_dn = std::max(kSigmas * background.noise_dn, kLeastContrastDn * scale);
  // Limited by the bytes, not by the bits: pixels beyond their depth must not put it below the background.
  const int limit_dn = image.BytesPerPixel() == 1 ? 0xFF : 0xFFFF;
  const int threshold = std::min(limit_dn, static_cast<int>(std::ceil(background.level_dn + contrast_dn)));
  out.background_dn = static_cast<float>(background.level_dn);
  out.noise_dn = static_cast<float>(background.noise_dn);
  out.threshold_dn = static_cast<float>(threshold);
  if (!state_->components.Segment(image, threshold)) {
    ++out.rejects.no_room;
    return;
  }
  const PixelNoise noise{state_->options.read_noise_dn * scale, state_->options.electrons_per_dn / scale,
                         background.level_dn};
  state_->Choose(image, noise, out);
  state_->Measure(image);
  state_->Emit(image, out);
}

}  // namespace adit::detect
