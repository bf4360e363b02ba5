// World::TruthAt and what it rests on.
#include <algorithm>
#include <cmath>

#include "drivers/sim/world.h"

namespace adit::sim {

using base::Side;
using Eigen::Vector2d;
using Eigen::Vector3d;

int TargetTruth::Visible() const {
  int count = 0;
  for (std::size_t i = 0; i < base::kLedCount; ++i)
    count += views[0][i] == LedView::kVisible && views[1][i] == LedView::kVisible ? 1 : 0;
  return count;
}

std::vector<std::optional<World::Trace>> World::TraceAll(Side side, double t_s, double factor) const {
  const double half_s = factor * scene_.exposure_s / 2;
  std::vector<std::optional<Trace>> traces(lights_.size());
  for (std::size_t i = 0; i < lights_.size(); ++i) {
    const auto seen = Receive(i, side, t_s);
    if (!seen || seen->shown == 0) continue;
    Disc disc = seen->disc;
    disc.flux_dn *= factor;
    Trace trace{{disc.x_px, disc.y_px}, painter_.ExtentPx(disc, kDarkDn)};
    if (!AtRest(i)) {
      const auto start = Receive(i, side, t_s - half_s), end = Receive(i, side, t_s + half_s);
      if (start && end)
        trace.extent_px +=
            0.5 * std::hypot(end->disc.x_px - start->disc.x_px, end->disc.y_px - start->disc.y_px);
    }
    traces[i] = trace;
  }
  return traces;
}

LedView World::View(std::size_t light, Side side, double t_s,
                    const std::vector<std::optional<Trace>>& traces) const {
  const Source& source = lights_[light];
  if (std::any_of(source.off->begin(), source.off->end(), [t_s](const Interval& i) { return i.Holds(t_s); }))
    return LedView::kOff;
  const auto seen = Receive(light, side, t_s);
  const optics::CameraModel& camera = Camera(side);
  const double margin_px = kImageMarginPx + (seen ? seen->disc.radius_px : 0);
  if (!seen || seen->disc.x_px < margin_px || seen->disc.y_px < margin_px ||
      seen->disc.x_px > camera.width_px - 1 - margin_px || seen->disc.y_px > camera.height_px - 1 - margin_px)
    return LedView::kOutside;
  const double half_s = ExposureFactor(t_s) * scene_.exposure_s / 2;
  for (const double at_s : {t_s - half_s, t_s, t_s + half_s}) {
    const auto then = Receive(light, side, at_s);
    if (!then || then->shown != kAllShown) return LedView::kHidden;
  }
  for (std::size_t i = 0; i < traces.size(); ++i) {
    if (i == light || !traces[i]) continue;
    const double apart_px = (traces[i]->centre_px - traces[light]->centre_px).norm();
    if (apart_px < traces[i]->extent_px + traces[light]->extent_px + kClearPx) return LedView::kCrowded;
  }
  return LedView::kVisible;
}

std::vector<TargetTruth> World::TruthAt(std::uint64_t trigger) const {
  const double t_s = MidExposureS(trigger);
  const double factor = ExposureFactor(t_s);
  std::vector<TargetTruth> truths(scene_.targets.size());
  for (std::size_t k = 0; k < truths.size(); ++k) {
    const SceneTarget& target = scene_.targets[k];
    const auto pose = target.motion->At(t_s);
    TargetTruth& truth = truths[k];
    truth.target = k;
    truth.direction = pose.rotation * target.direction;
    const Vector3d led1_m = pose * target.led1_m;
    truth.epicenter_m = led1_m + target.target.epicenter_m * truth.direction;
    for (std::size_t i = 0; i < base::kLedCount; ++i)
      truth.leds_m[i] = led1_m + target.target.leds_m[i] * truth.direction;
  }
  for (const Side side : {Side::kLeft, Side::kRight}) {
    const auto traces = TraceAll(side, t_s, factor);
    for (std::size_t k = 0; k < truths.size(); ++k)
      for (std::size_t i = 0; i < base::kLedCount; ++i)
        truths[k].views[static_cast<std::size_t>(side)][i] = View(base::kLedCount * k + i, side, t_s, traces);
  }
  return truths;
}

}  // namespace adit::sim
