// The image pairs that the speed is measured on: two bars among saturated discs, as many as the scenario
// says.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "firmware/base/image.h"
#include "firmware/identify/model.h"
#include "firmware/optics/rig.h"

namespace adit::bench {

inline constexpr int kWidthPx = 1400, kHeightPx = 1024;

/// What the images lie in: pages of 4 kB, or of 2 MB as the cameras' buffers do where the kernel grants them.
enum class Pages : std::uint8_t { kOrdinary, kHuge };

struct Size {
  int width_px = kWidthPx, height_px = kHeightPx;
  std::size_t Bytes() const {
    return static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px);
  }
};

/// One image, 8 bit.
class Image {
 public:
  explicit Image(const Size& size = {}, Pages pages = Pages::kOrdinary);
  Image(const Image& other, Pages pages);

  std::span<std::uint8_t> Pixels() { return {memory_.get(), size_.Bytes()}; }
  std::span<const std::uint8_t> Pixels() const { return {memory_.get(), size_.Bytes()}; }
  const Size& GetSize() const { return size_; }

 private:
  Size size_;
  struct Unmap {
    void operator()(std::uint8_t* memory) const;
  };
  std::unique_ptr<std::uint8_t, Unmap> memory_;
};

struct ImagePair {
  Image left, right;
  base::CameraFrame Frame(base::Side side, base::TimeNs time_ns) const;
};
/// Copies in other pages.
std::vector<ImagePair> InPages(const std::vector<ImagePair>& pairs, Pages pages);

/// What all pairs show.
struct Stage {
  optics::Rig rig;
  std::vector<identify::Model> models;  ///< of the bars
};
Stage MakeStage(std::size_t targets);

/// `count` different pairs: background 6 DN with noise of 1.7 DN, bars with LEDs of sigma 1.2 to 2.5 px and
/// 214 DN, and `lamps` discs at full scale in each image with radii of 2 to 30 px, as lamps near the camera
/// are. The bars, one of each of MakeStage's targets, move a tenth of a metre from pair to pair, the last
/// pair being next to the first.
std::vector<ImagePair> RenderDrive(int count, std::size_t bars, int lamps, unsigned seed);

/// What a curve varies. Spots are as small as LEDs: each becomes a blob.
struct Crowd {
  Size size;
  std::size_t targets = 2;  ///< up to 32, side by side
  int spots = 0;            ///< in each image, beside the LEDs
};
Stage MakeStage(const Crowd& crowd);
std::vector<ImagePair> RenderCrowd(const Crowd& crowd, int count, unsigned seed);

}  // namespace adit::bench
