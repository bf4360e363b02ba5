// Where the next images are searched: around the LEDs that are being followed, and all over often enough that
// nothing which enters is found more than two pairs late.
#pragma once

#include <array>
#include <cstdint>

#include "firmware/base/image.h"
#include "firmware/detect/window.h"
#include "firmware/stereo/point_set.h"
#include "firmware/track/target_state.h"

namespace adit::pipeline {

/// One LED in one image, as taken.
struct SeenLed {
  float x_px = 0, y_px = 0;
  float x_px_per_s = 0, y_px_per_s = 0;
  float half_px = 0;   ///< of the longer side of its box
  float px_per_m = 0;  ///< at its distance
};

/// For both detections to read while the next plan is being made.
struct SearchPlan {
  static constexpr std::size_t kMaxLeds =
      8 * base::kLedCount;  ///< more targets than this are sought all over

  base::TimeNs seen_ns = base::kNever;  ///< the exposure in which the LEDs were seen
  bool whole = true;                    ///< the next images are to be searched all over
  std::uint32_t led_count = 0;
  std::array<std::array<SeenLed, kMaxLeds>, 2> leds{};  ///< of the left image and of the right

  /// What to search in an image exposed at `exposure_ns`: none means all of it.
  detect::Windows WindowsIn(const base::CameraFrame& frame) const;
};

/// Makes the plans, pair after pair. One thread; no allocation.
class SearchPlanner {
 public:
  explicit SearchPlanner(double focal_px) : focal_px_(static_cast<float>(focal_px)) {}

  /// `points` of a pair, its blob sets reached through it, and what the tracking made of them: where nobody
  /// believes a target to be it is not followed.
  const SearchPlan& Next(const stereo::PointSet& points, const track::TargetStateSet& states);

 private:
  /// The LEDs of one target in the last pair that showed it.
  struct Trail {
    base::TimeNs seen_ns = base::kNever;
    std::array<std::array<SeenLed, base::kLedCount>, 2> leds{};
  };
  bool Follow(const stereo::PointSet& points, const stereo::TargetPoints& target);

  float focal_px_;
  SearchPlan plan_;
  std::array<Trail, identify::kMaxTargets> trails_;
  int pairs_since_whole_ = 0;
};

}  // namespace adit::pipeline
