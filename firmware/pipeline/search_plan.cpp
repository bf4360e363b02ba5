#include "firmware/pipeline/search_plan.h"

#include <algorithm>
#include <cmath>

namespace adit::pipeline {
namespace {

// How far an LED may be from where its speed takes it: by what the tripod shakes and the blob grows, and by
// 50 m/s^2 of the machine, five times gravity.
constexpr float kMarginPx = 8;
constexpr float kAccelerationMPerS2 = 50;
// Windows are at least as wide as the narrowest rows that are scanned at once, 32 px.
constexpr float kLeastAsidePx = 15.5;
// Older than this a place says nothing.
constexpr base::DurationNs kOldNs = 100 * base::kNsPerMs;
// Pairs between two that are searched all over. While a target is missing, every second one is, so that it is
// found two pairs late at most. While every target is followed nobody can enter: what is looked for four
// times a second (at 60 Hz) is whether another place in the image claims to be one of them.
constexpr int kPairsApartFollowed = 14, kPairsApartMissing = 1;

SeenLed LedOf(const detect::Blob& blob) {
  SeenLed led;
  led.x_px = static_cast<float>(blob.raw_px.x()), led.y_px = static_cast<float>(blob.raw_px.y());
  led.half_px =
      0.5F * static_cast<float>(std::max(blob.x_max_px - blob.x_min_px, blob.y_max_px - blob.y_min_px) + 1);
  return led;
}

}  // namespace

detect::Windows SearchPlan::WindowsIn(const base::CameraFrame& frame) const {
  detect::Windows windows;
  const base::DurationNs age_ns = frame.stamp.mid_exposure_ns - seen_ns;
  if (whole || seen_ns == base::kNever || age_ns <= 0 || age_ns > kOldNs) return windows;
  const float age_s = static_cast<float>(age_ns) / static_cast<float>(base::kNsPerS);
  const auto side = static_cast<std::size_t>(frame.stamp.side);
  for (std::size_t i = 0; i < led_count; ++i) {
    const SeenLed& led = leds[side][i];
    const float x_px = led.x_px + age_s * led.x_px_per_s, y_px = led.y_px + age_s * led.y_px_per_s;
    // Backward differences lag by half a pair, so that the whole square of the age counts.
    const float reach_px = led.half_px + kMarginPx + kAccelerationMPerS2 * age_s * age_s * led.px_per_m;
    const float aside_px = std::max(reach_px, kLeastAsidePx);
    const auto clip = [](float px, int size_px) {
      return static_cast<int>(std::clamp(px, 0.0F, static_cast<float>(size_px - 1)));
    };
    const int width_px = frame.image.width_px, height_px = frame.image.height_px;
    const detect::Window window{clip(x_px - aside_px, width_px), clip(y_px - reach_px, height_px),
                                clip(x_px + aside_px, width_px), clip(y_px + reach_px, height_px)};
    if (!detect::Add(windows, window)) return {};
  }
  return windows;
}

/// Adds a target's LEDs to the plan. False if it cannot be followed: it was not seen in the pair before.
bool SearchPlanner::Follow(const stereo::PointSet& points, const stereo::TargetPoints& target) {
  Trail& trail = trails_[target.target];
  const base::TimeNs now_ns = points.stamp.mid_exposure_ns;
  const base::DurationNs since_ns = trail.seen_ns == base::kNever ? 0 : now_ns - trail.seen_ns;
  const bool known = since_ns > 0 && since_ns <= kOldNs;
  const float since_s = static_cast<float>(since_ns) / static_cast<float>(base::kNsPerS);
  const bool room = plan_.led_count + base::kLedCount <= SearchPlan::kMaxLeds;
  for (std::size_t side = 0; side < 2; ++side) {
    const auto& blobs = (side == 0 ? points.left : points.right)->blob_set->blobs;
    const auto distance_m = static_cast<float>(target.epicenter_b_m.norm());
    const float scale_px_per_m = focal_px_ / distance_m;
    for (std::size_t i = 0; i < base::kLedCount; ++i) {
      SeenLed led = LedOf(blobs[target.blobs[side][i]]);
      const SeenLed& before = trail.leds[side][i];
      if (known) {
        led.x_px_per_s = (led.x_px - before.x_px) / since_s;
        led.y_px_per_s = (led.y_px - before.y_px) / since_s;
      }
      trail.leds[side][i] = led;
      led.px_per_m = scale_px_per_m;
      if (known && room) plan_.leds[side][plan_.led_count + i] = led;
    }
  }
  trail.seen_ns = now_ns;
  if (known && room) plan_.led_count += base::kLedCount;
  return known && room;
}

const SearchPlan& SearchPlanner::Next(const stereo::PointSet& points, const track::TargetStateSet& states) {
  const bool was_whole = points.left->blob_set->whole && points.right->blob_set->whole;
  pairs_since_whole_ = was_whole ? 0 : pairs_since_whole_ + 1;
  plan_.seen_ns = points.stamp.mid_exposure_ns;
  plan_.led_count = 0;
  std::size_t followed = 0;
  bool lost = false, entered = false;
  for (const stereo::TargetPoints& target : points.targets) {
    const bool believed = states.targets[target.target].points.reason != stereo::LossReason::kJump;
    if (target.status == stereo::FixStatus::kTracked && believed) {
      const bool follows = Follow(points, target);
      followed += follows ? 1 : 0;
      entered = entered || !follows;
    } else {
      entered = entered || (target.status == stereo::FixStatus::kRecovered && believed);
      lost = lost || trails_[target.target].seen_ns != base::kNever;
      trails_[target.target].seen_ns = base::kNever;
    }
  }
  const int apart = followed == points.targets.size() ? kPairsApartFollowed : kPairsApartMissing;
  // One sight tells no speed, and a bar with hidden LEDs not where each of them comes back: no window then,
  // and without a whole search at once the target would be lost again.
  plan_.whole = followed == 0 || lost || entered || pairs_since_whole_ >= apart;
  return plan_;
}

}  // namespace adit::pipeline
