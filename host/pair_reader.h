// The pairs of a recording, one after the other, read ahead on other cores.
#pragma once

#include <array>
#include <deque>
#include <future>
#include <optional>
#include <string>
#include <vector>

#include "drivers/recording/recording.h"
#include "firmware/base/image.h"
#include "firmware/base/result.h"
#include "firmware/optics/camera_model.h"

namespace adit::host {

/// Two images of one exposure.
struct ImagePair {
  base::TimeNs mid_exposure_ns = 0;
  std::uint64_t trigger = 0;  ///< place of the left image in the recording
  std::array<recording::StoredImage, 2> images;

  /// As a driver delivers it; refers to this pair's pixels.
  base::CameraFrame Frame(base::Side side) const;
};

/// What the images must be, and the file that says so.
struct ImageSize {
  int width_px = 0, height_px = 0;
  std::string file;

  static ImageSize Of(const optics::CameraModel& camera, const std::string& file) {
    return {camera.width_px, camera.height_px, file};
  }
};

/// Reads pair by pair, paired by time as the box does it (capture::Pairer); images without a partner are
/// counted and left out.
class PairReader {
 public:
  /// Opens the folder. Declines with the recording's own line, or when no pair is in it.
  static base::Result<PairReader> Open(const std::string& folder, const ImageSize& left,
                                       const ImageSize& right);

  std::size_t Pairs() const { return pairs_.size(); }
  std::size_t Unpaired() const { return unpaired_; }

  /// Mid-exposure of a pair.
  base::TimeNs MidExposureNs(std::size_t pair) const { return pairs_[pair].images[0].mid_exposure_ns; }
  /// Leaves out all pairs before this one; only before the first Next.
  void StartAt(std::size_t pair);

  /// The next pair, or none after the last. Declines an image that cannot be read or is not of the camera's
  /// size.
  base::Result<std::optional<ImagePair>> Next();

 private:
  using Loading = std::future<base::Result<recording::StoredImage>>;
  struct Entry {
    std::array<recording::ImageEntry, 2> images;
    std::uint64_t trigger;
  };
  PairReader(const recording::Recording& recording, const ImageSize& left, const ImageSize& right);
  void ReadAhead();

  std::vector<Entry> pairs_;
  std::array<ImageSize, 2> sizes_;
  std::size_t unpaired_ = 0;
  std::size_t next_ = 0, ahead_ = 0;  ///< indices of the next pair handed out, and of the next one to read
  std::deque<std::array<Loading, 2>> loading_;
};

}  // namespace adit::host
