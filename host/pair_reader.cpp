#include "host/pair_reader.h"

#include <algorithm>
#include <utility>

#include "firmware/capture/pairer.h"

namespace adit::host {
namespace {

using base::Error;
using base::ErrorCode;

constexpr std::size_t kPairsAhead = 3;  // two cores decode while one pair is worked on

std::string SizeText(int width_px, int height_px) {
  return std::to_string(width_px) + " x " + std::to_string(height_px) + " px";
}

/// Between triggers: the median, which lost frames do not move.
base::DurationNs PeriodNs(const std::vector<recording::ImageEntry>& images) {
  std::vector<base::DurationNs> steps_ns;
  for (std::size_t i = 1; i < images.size(); ++i)
    steps_ns.push_back(images[i].mid_exposure_ns - images[i - 1].mid_exposure_ns);
  if (steps_ns.empty()) return capture::PairerOptions{}.period_ns;
  const auto middle = steps_ns.begin() + static_cast<std::ptrdiff_t>(steps_ns.size() / 2);
  std::nth_element(steps_ns.begin(), middle, steps_ns.end());
  return *middle;
}

}  // namespace

base::CameraFrame ImagePair::Frame(base::Side side) const {
  base::CameraFrame frame;
  frame.stamp.mid_exposure_ns = mid_exposure_ns;
  frame.stamp.last_packet_ns = mid_exposure_ns;  // a recording does not know
  frame.stamp.trigger = trigger;
  frame.stamp.side = side;
  frame.image = images[static_cast<std::size_t>(side)].View();
  return frame;
}

base::Result<PairReader> PairReader::Open(const std::string& folder, const ImageSize& left,
                                          const ImageSize& right) {
  const auto recording = recording::OpenRecording(folder);
  if (!recording) return recording.error();
  PairReader reader(*recording, left, right);
  if (reader.pairs_.empty()) {
    return Error{ErrorCode::kFailed, folder,
                 "holds no two images of one trigger (" + std::to_string(recording->left.size()) + " left, " +
                     std::to_string(recording->right.size()) + " right)"};
  }
  return reader;
}

PairReader::PairReader(const recording::Recording& recording, const ImageSize& left, const ImageSize& right)
    : sizes_{left, right} {
  struct Place {
    base::Side side;
    std::size_t index;
  };
  capture::PairerOptions options;
  options.period_ns = PeriodNs(recording.left);
  capture::Pairer<Place> pairer(options);
  const auto collect = [&] {
    while (const auto event = pairer.Next(base::kNever)) {
      if (!event->Paired()) continue;
      pairs_.push_back(
          {{recording.left[event->left->index], recording.right[event->right->index]}, event->left->index});
    }
  };
  std::size_t l = 0, r = 0;
  while (l < recording.left.size() || r < recording.right.size()) {
    const bool is_left = r == recording.right.size() ||
                         (l < recording.left.size() &&
                          recording.left[l].mid_exposure_ns <= recording.right[r].mid_exposure_ns);
    const Place place{is_left ? base::Side::kLeft : base::Side::kRight, is_left ? l++ : r++};
    base::FrameStamp stamp;
    stamp.side = place.side;
    stamp.mid_exposure_ns = (is_left ? recording.left : recording.right)[place.index].mid_exposure_ns;
    pairer.Add(stamp, place);
    collect();
  }
  unpaired_ = recording.left.size() + recording.right.size() - 2 * pairs_.size();
}

void PairReader::StartAt(std::size_t pair) {
  ADIT_REQUIRE(loading_.empty() && pair <= pairs_.size());
  next_ = ahead_ = pair;
}

void PairReader::ReadAhead() {
  for (; ahead_ < pairs_.size() && loading_.size() < kPairsAhead; ++ahead_) {
    std::array<Loading, 2> both;
    for (const std::size_t side : {0U, 1U}) {
      both[side] = std::async(std::launch::async, [path = pairs_[ahead_].images[side].path] {
        return recording::ReadCameraImage(path);
      });
    }
    loading_.push_back(std::move(both));
  }
}

base::Result<std::optional<ImagePair>> PairReader::Next() {
  if (next_ == pairs_.size()) return std::optional<ImagePair>{};
  ReadAhead();
  const Entry& entry = pairs_[next_++];
  std::array<Loading, 2> both = std::move(loading_.front());
  loading_.pop_front();
  ImagePair pair;
  pair.mid_exposure_ns = entry.images[0].mid_exposure_ns;
  pair.trigger = entry.trigger;
  for (const std::size_t side : {0U, 1U}) {
    auto image = both[side].get();
    if (!image) return image.error();
    const ImageSize& size = sizes_[side];
    if (image->width_px != size.width_px || image->height_px != size.height_px) {
      return Error{ErrorCode::kMalformed, entry.images[side].path,
                   "is " + SizeText(image->width_px, image->height_px) + "; " + size.file + " says " +
                       SizeText(size.width_px, size.height_px) + " for cam" + std::to_string(side)};
    }
    pair.images[side] = std::move(*image);
  }
  return std::optional<ImagePair>(std::move(pair));
}

}  // namespace adit::host
