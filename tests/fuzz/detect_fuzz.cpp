// Any pixels, sizes, strides and depths through the detection: whatever it hands on lies inside the image and
// is finite.
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "firmware/base/require.h"
#include "firmware/detect/detector.h"

namespace {

using adit::base::FrameStatus;
using adit::base::ImageView;
using adit::detect::Blob;
using adit::detect::BlobSet;
using adit::detect::Detector;
using Bytes = std::span<const std::uint8_t>;

const adit::detect::DetectorOptions kOptions;

/// A camera of few sizes, about the 64 pixels that rows are scanned in, and its detector, used again and
/// again.
struct Camera {
  adit::optics::CameraModel model;
  std::unique_ptr<Detector> detector;

  Camera(int width_px, int height_px) {
    model.width_px = width_px, model.height_px = height_px;
    model.fu_px = model.fv_px = 300;
    model.cu_px = width_px / 2.0, model.cv_px = height_px / 2.0;
    model.k1 = -0.1;
    detector = std::make_unique<Detector>(model, kOptions);
  }
};

Camera& CameraOf(std::uint8_t choice) {
  static std::array<Camera, 8> cameras{Camera{1, 1},   Camera{5, 9},   Camera{40, 30},  Camera{63, 20},
                                       Camera{64, 64}, Camera{65, 33}, Camera{129, 17}, Camera{200, 50}};
  return cameras[choice % cameras.size()];
}

void Put(std::vector<std::uint8_t>& pixels, const ImageView& image, Eigen::Vector2i at, unsigned value) {
  const auto row = static_cast<std::size_t>(at.y() * image.stride_bytes);
  const auto byte = row + static_cast<std::size_t>(at.x() * image.BytesPerPixel());
  pixels[byte] = static_cast<std::uint8_t>(value);
  if (image.BytesPerPixel() == 2) pixels[byte + 1] = static_cast<std::uint8_t>(value >> 8);
}

/// Random pixels seldom make spots: five bytes paint one ellipse.
void Paint(std::vector<std::uint8_t>& pixels, const ImageView& image, Bytes bytes) {
  for (; bytes.size() >= 5; bytes = bytes.subspan(5)) {
    const Eigen::Vector2i middle(bytes[0] % image.width_px, bytes[1] % image.height_px);
    const int a = 1 + bytes[2] % 16, b = 1 + bytes[2] / 16;
    const unsigned value = bytes[3] | static_cast<unsigned>(bytes[4]) << 8;
    for (int y = std::max(0, middle.y() - b); y <= std::min(image.height_px - 1, middle.y() + b); ++y) {
      for (int x = std::max(0, middle.x() - a); x <= std::min(image.width_px - 1, middle.x() + a); ++x) {
        const int dx = (x - middle.x()) * b, dy = (y - middle.y()) * a;
        if (dx * dx + dy * dy <= a * a * b * b) Put(pixels, image, {x, y}, value);
      }
    }
  }
}

/// Up to three windows, which a plan would clip to the image in the same way; mostly none: the whole image.
adit::detect::Windows WindowsOf(std::uint8_t choice, Bytes bytes, const ImageView& image) {
  adit::detect::Windows windows;
  for (int i = choice >> 6; i > 0 && bytes.size() >= 4; --i, bytes = bytes.subspan(4)) {
    const int x_px = bytes[0] % image.width_px, y_px = bytes[1] % image.height_px;
    adit::detect::Add(windows, {x_px, y_px, std::min(x_px + bytes[2], image.width_px - 1),
                                std::min(y_px + bytes[3], image.height_px - 1)});
  }
  return windows;
}

void CheckBlob(const Blob& blob, const BlobSet& set, const ImageView& image) {
  // Nothing that touches a border, and the centroid in its box.
  ADIT_REQUIRE(0 < blob.x_min_px && blob.x_min_px <= blob.x_max_px && blob.x_max_px < image.width_px - 1);
  ADIT_REQUIRE(0 < blob.y_min_px && blob.y_min_px <= blob.y_max_px && blob.y_max_px < image.height_px - 1);
  ADIT_REQUIRE(blob.raw_px.x() >= blob.x_min_px && blob.raw_px.x() <= blob.x_max_px);
  ADIT_REQUIRE(blob.raw_px.y() >= blob.y_min_px && blob.raw_px.y() <= blob.y_max_px);
  ADIT_REQUIRE(blob.ideal_px.allFinite() && blob.covariance_px2.allFinite());
  ADIT_REQUIRE(blob.covariance_px2(0, 0) > 0 && blob.covariance_px2.determinant() > 0);
  ADIT_REQUIRE(blob.area_px >= kOptions.area_min_px && blob.area_px <= kOptions.area_max_px);
  ADIT_REQUIRE(blob.peak_dn > set.threshold_dn && set.threshold_dn >= set.background_dn);
  ADIT_REQUIRE(blob.flux_dn > 0 &&
               blob.saturated == (blob.peak_dn >= static_cast<float>((1 << image.bits) - 1)));
  ADIT_REQUIRE(blob.sigma_minor_px > 0 && blob.sigma_major_px >= blob.sigma_minor_px);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t kHead = 5;
  if (size < kHead) return 0;
  const Bytes rest(data + kHead, size - kHead);
  const Camera& camera = CameraOf(data[0]);
  adit::base::CameraFrame frame;
  ImageView& image = frame.image;
  image.width_px = camera.model.width_px, image.height_px = camera.model.height_px;
  image.bits = 7 + data[1] % 7;
  const int row_bytes = image.width_px * image.BytesPerPixel();
  image.stride_bytes = row_bytes + data[2] % 6;
  // Exactly as large as the image: what reads further is seen.
  std::vector<std::uint8_t> pixels(
      static_cast<std::size_t>(image.stride_bytes * (image.height_px - 1) + row_bytes), data[3]);
  if (data[4] % 4 == 0) {  // any bytes, beyond the depth too
    for (std::size_t i = 0; i < pixels.size() && !rest.empty(); ++i) pixels[i] = rest[i % rest.size()];
  } else {
    for (int y = 0; y < image.height_px; ++y)
      for (int x = 0; x < image.width_px; ++x) Put(pixels, image, {x, y}, data[3] % 64U);
    Paint(pixels, image, rest.first(std::min<std::size_t>(rest.size(), 5 * (data[4] / 4U))));
  }
  image.data = pixels.data();
  const bool overlap = data[2] >= 250;
  if (overlap) image.stride_bytes = row_bytes - 1;
  static const auto blobs = std::make_unique<BlobSet>();
  camera.detector->Detect(frame, WindowsOf(data[1], rest, image), *blobs);
  const bool refused = overlap || image.bits < 8 || image.bits > 12;
  ADIT_REQUIRE(refused == (blobs->stamp.status != FrameStatus::kOk));
  ADIT_REQUIRE(!refused || blobs->blobs.empty());
  ADIT_REQUIRE(blobs->blobs.size() <= adit::detect::kMaxBlobs);
  for (const Blob& blob : blobs->blobs) CheckBlob(blob, *blobs, image);
  return 0;
}
