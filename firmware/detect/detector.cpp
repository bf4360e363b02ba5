#include "firmware/detect/detector.h"

#include <algorithm>
#include <cmath>

#include "firmware/base/prefetch.h"
#include "firmware/base/require.h"
#include "firmware/detect/background.h"
#include "firmware/detect/centroid.h"
#include "firmware/detect/components.h"
#include "firmware/detect/refine.h"

namespace adit::detect {
namespace {

// A pixel is bright above background + kSigmas * noise: of 1.4 million Gaussian pixels 0.0014 do so by
// chance.
constexpr double kSigmas = 6;
// and never nearer than this to the background, at 8 bit: uneven veils and glare stay dark, and the weight I
// - T is within 1.2 of the bound for peaks from 50 DN on (bounds simulated for T = 12 to 30).
constexpr double kLeastContrastDn = 12;

// Two LEDs of 200 DN and sigma 1.5 px merge up to 7 px apart, which makes them 2.6 x as long as wide,
// more above a threshold.
constexpr double kLongestPair = 5;

/// What of a merged region is one LED's.
void Share(const LedPlace& place, double full_dn, Blob& blob) {
  blob.merged = true;
  blob.flux_dn = static_cast<float>(2 * M_PI * place.sigma_px * place.sigma_px * place.height_dn);
  blob.peak_dn = static_cast<float>(std::min<double>(blob.peak_dn, blob.background_dn + place.height_dn));
  blob.sigma_major_px = blob.sigma_minor_px = static_cast<float>(place.sigma_px);
  blob.saturated = blob.peak_dn >= static_cast<float>(full_dn);
}

/// The rows of small windows lie in lines and pages of their own: fetched one after the other they would cost
/// more than all the rest.
void Fetch(const base::ImageView& image, const Window& window) {
  const std::ptrdiff_t bytes = image.BytesPerPixel();
  for (int y = window.y_min_px; y <= window.y_max_px; ++y)
    base::Prefetch(image.Row(y) + bytes * window.x_min_px, bytes * window.WidthPx());
}

}  // namespace

struct Detector::State {
  optics::CameraModel camera;
  DetectorOptions options;
  Components components;

  State(const optics::CameraModel& model, const DetectorOptions& given) : camera(model), options(given) {
    ADIT_REQUIRE(model.width_px <= LitRows::kMaxSidePx && model.height_px <= LitRows::kMaxSidePx);
  }

  void Search(const base::ImageView& image, const Window& window, const PixelNoise& noise, BlobSet& out);
  std::uint32_t* ReasonToDrop(const Component& component, const Window& window, BlobSet& out) const;
  bool Measure(const base::ImageView& image, const Component& component, const PixelNoise& noise,
               BlobSet& out) const;
};

Detector::Detector(const optics::CameraModel& camera, const DetectorOptions& options)
    : state_(std::make_unique<State>(camera, options)) {}
Detector::~Detector() = default;
Detector::Detector(Detector&&) noexcept = default;
Detector& Detector::operator=(Detector&&) noexcept = default;

/// The counter of what is wrong with a component by its area and box alone, or null.
std::uint32_t* Detector::State::ReasonToDrop(const Component& component, const Window& window,
                                             BlobSet& out) const {
  const Component& c = component;
  if (c.area_px < options.area_min_px) return &out.rejects.too_small;
  if (c.area_px > options.area_max_px) return &out.rejects.too_large;
  if (c.x_min_px == window.x_min_px || c.y_min_px == window.y_min_px || c.x_max_px == window.x_max_px ||
      c.y_max_px == window.y_max_px)
    return &out.rejects.at_border;
  // A round spot is not much longer than the circle of its area; what is thrice as long goes without a look
  // at its pixels.
  constexpr double kBoxSlack = 3;
  const double longest_px = std::max(c.x_max_px - c.x_min_px, c.y_max_px - c.y_min_px) + 1;
  const double limit_px = kBoxSlack * options.elongation_max;
  if (longest_px * longest_px > limit_px * limit_px * (4 / M_PI) * c.area_px) return &out.rejects.not_round;
  if (out.blobs.size() == kMaxBlobs) return &out.rejects.no_room;
  return nullptr;
}

/// Adds the blob of a component, or two if two LEDs merged in it. False if it is neither round nor two or
/// lies where the lens does not image.
bool Detector::State::Measure(const base::ImageView& image, const Component& component,
                              const PixelNoise& noise, BlobSet& out) const {
  const Component& c = component;
  const auto threshold_dn = static_cast<int>(out.threshold_dn);
  const Eigen::Vector2i origin_px(c.x_min_px, c.y_min_px);
  const SpotMoments spot(SumLight(image, components.RunsOf(c), origin_px, threshold_dn), origin_px,
                         threshold_dn, noise);
  const Eigen::Vector2d sigmas_px = spot.SigmasPx();
  const double full_dn = (1 << image.bits) - 1;
  if (!(sigmas_px.x() <= kLongestPair * sigmas_px.y())) return false;
  LedPlaces places = Refine(image, c, spot, threshold_dn, {noise, full_dn});
  const bool merged = places.size() == 2;
  if (!merged && !(sigmas_px.x() <= options.elongation_max * sigmas_px.y())) return false;
  if (places.empty()) places.push_back({spot.CentroidPx(), spot.CovariancePx2()});
  Blob blob;
  blob.flux_dn = static_cast<float>(spot.FluxDn());
  blob.peak_dn = static_cast<float>(spot.PeakDn());
  blob.background_dn = static_cast<float>(noise.background_dn);
  blob.area_px = static_cast<float>(c.area_px);
  blob.sigma_major_px = static_cast<float>(sigmas_px.x());
  blob.sigma_minor_px = static_cast<float>(sigmas_px.y());
  blob.x_min_px = c.x_min_px, blob.y_min_px = c.y_min_px;
  blob.x_max_px = c.x_max_px, blob.y_max_px = c.y_max_px;
  blob.saturated = spot.PeakDn() >= full_dn;
  for (const LedPlace& place : places) {
    Eigen::Matrix2d slope;
    const auto ideal_px = camera.Undistort(place.centre_px, &slope);
    if (!ideal_px) return false;
    blob.raw_px = place.centre_px;
    blob.ideal_px = *ideal_px;
    blob.covariance_px2 = slope * place.covariance_px2 * slope.transpose();
    if (merged) Share(place, full_dn, blob);
    if (!out.blobs.push_back(blob)) ++out.rejects.no_room;
  }
  return true;
}

void Detector::State::Search(const base::ImageView& image, const Window& window, const PixelNoise& noise,
                             BlobSet& out) {
  const int threshold_dn = static_cast<int>(out.threshold_dn);
  if (!components.Segment(image, window, threshold_dn)) {
    ++out.rejects.no_room;
    return;
  }
  for (const Component& component : components.All()) {
    std::uint32_t* reason = ReasonToDrop(component, window, out);
    if (reason == nullptr) {
      if (!Measure(image, component, noise, out)) reason = &out.rejects.not_round;
    }
    if (reason == nullptr) continue;
    ++*reason;
    if (reason != &out.rejects.too_small)
      out.regions.push_back({component.x_min_px, component.y_min_px, component.x_max_px, component.y_max_px});
  }
}

void Detector::Detect(const base::CameraFrame& frame, const Windows& windows, BlobSet& out) {
  const base::ImageView& image = frame.image;
  out.stamp = frame.stamp;
  out.whole = windows.empty();
  out.blobs.clear();
  out.rejects = {};
  out.regions.clear();
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
  FetchBackground(image);
  for (const Window& window : windows) Fetch(image, window);
  const Background background = EstimateBackground(image);
  const double contrast_dn = std::max(kSigmas * background.noise_dn, kLeastContrastDn * scale);
  // Limited by the bytes, not by the bits: pixels beyond their depth must not put it below the background.
  const int limit_dn = image.BytesPerPixel() == 1 ? 0xFF : 0xFFFF;
  const int threshold = std::min(limit_dn, static_cast<int>(std::ceil(background.level_dn + contrast_dn)));
  out.background_dn = static_cast<float>(background.level_dn);
  out.noise_dn = static_cast<float>(background.noise_dn);
  out.threshold_dn = static_cast<float>(threshold);
  const PixelNoise noise{state_->options.read_noise_dn * scale, state_->options.electrons_per_dn / scale,
                         background.level_dn};
  if (windows.empty()) state_->Search(image, {0, 0, image.width_px - 1, image.height_px - 1}, noise, out);
  for (const Window& window : windows) state_->Search(image, window, noise, out);
}

}  // namespace adit::detect
