// Any pixels, sizes, strides and depths through the detection: whatever it hands on lies inside the image and
// is finite.
#include <Eigen/LU>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "firmware/base/require.h"
#include "firmware/detect/detector.h"

namespace {

using adit::detect::Blob;

void CheckBlob(const Blob& blob, const adit::base::ImageView& image) {
  ADIT_REQUIRE(blob.x_min_px <= blob.x_max_px && blob.x_max_px < image.width_px);
  ADIT_REQUIRE(blob.y_min_px <= blob.y_max_px && blob.y_max_px < image.height_px);
  ADIT_REQUIRE(blob.raw_px.x() >= blob.x_min_px && blob.raw_px.x() <= blob.x_max_px);
  ADIT_REQUIRE(blob.raw_px.y() >= blob.y_min_px && blob.raw_px.y() <= blob.y_max_px);
  ADIT_REQUIRE(blob.ideal_px.allFinite() && blob.covariance_px2.allFinite());
  ADIT_REQUIRE(blob.covariance_px2(0, 0) > 0 && blob.covariance_px2.determinant() > 0);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::size_t kHead = 4;
  if (size < kHead) return 0;
  adit::optics::CameraModel camera;
  camera.width_px = 1 + data[0] % 70;
  camera.height_px = 1 + data[1] % 40;
  camera.fu_px = camera.fv_px = 300;
  camera.cu_px = camera.width_px / 2.0, camera.cv_px = camera.height_px / 2.0;
  camera.k1 = -0.1;
  adit::base::CameraFrame frame;
  frame.image.width_px = camera.width_px, frame.image.height_px = camera.height_px;
  frame.image.bits = 7 + data[2] % 7;
  const int row_bytes = camera.width_px * frame.image.BytesPerPixel();
  frame.image.stride_bytes = row_bytes + data[3] % 5;
  // Exactly as large as the image: what reads further is seen.
  const auto bytes = static_cast<std::size_t>(frame.image.stride_bytes * (camera.height_px - 1) + row_bytes);
  std::vector<std::uint8_t> pixels(bytes);
  for (std::size_t i = 0; i < bytes; ++i) {
    // Two bytes a pixel: the high one stays within the depth, as cameras send it.
    const bool high = frame.image.bits > 8 && i % 2 == 1;
    pixels[i] = size == kHead ? 0 : data[kHead + i % (size - kHead)];
    if (high) pixels[i] = static_cast<std::uint8_t>(pixels[i] & ((1 << (frame.image.bits - 8)) - 1));
  }
  frame.image.data = pixels.data();
  static const auto blobs = std::make_unique<adit::detect::BlobSet>();
  adit::detect::Detector(camera, {}).Detect(frame, *blobs);
  for (const Blob& blob : blobs->blobs) CheckBlob(blob, frame.image);
  return 0;
}
