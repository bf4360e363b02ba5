#include "tests/bench/bench_frames.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/support/rendered_spots.h"
#include "tests/support/synthetic_bar.h"

namespace adit::bench {
namespace {

using support::SyntheticBar;
using support::SyntheticCamera;

constexpr double kBackgroundDn = 6, kNoiseDn = 1.7, kPeakDn = 214;
constexpr std::size_t kNoiseLength = 1 << 22;  // pixels of noise, begun anywhere: no image is like another

std::vector<float> NoiseBank(std::mt19937& random) {
  std::normal_distribution<float> gauss(0, static_cast<float>(kNoiseDn));
  std::vector<float> bank(kNoiseLength);
  for (float& value : bank) value = gauss(random);
  return bank;
}

/// Light of one image, as floats.
class Light {
 public:
  Light() : dn_(static_cast<std::size_t>(kWidthPx * kHeightPx), static_cast<float>(kBackgroundDn)) {}

  void AddLed(const Eigen::Vector2d& at_px, double sigma_px) {
    constexpr int kReachPx = 16;
    Each(at_px, kReachPx, [&](int x, int y, float& dn) {
      dn += static_cast<float>(kPeakDn * support::PixelShare(x, at_px.x(), sigma_px) *
                               support::PixelShare(y, at_px.y(), sigma_px));
    });
  }
  void AddDisc(const Eigen::Vector2d& at_px, double radius_px) {
    Each(at_px, static_cast<int>(radius_px) + 1, [&](int x, int y, float& dn) {
      if (std::hypot(x - at_px.x(), y - at_px.y()) <= radius_px) dn = 400;
    });
  }
  std::vector<std::uint8_t> Expose(const std::vector<float>& noise, std::size_t offset) const {
    std::vector<std::uint8_t> pixels(dn_.size());
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      const float value = dn_[i] + noise[(offset + i) % kNoiseLength];
      pixels[i] = static_cast<std::uint8_t>(std::clamp(std::lround(value), 0L, 255L));
    }
    return pixels;
  }

 private:
  template <typename Draw>
  void Each(const Eigen::Vector2d& at_px, int reach_px, const Draw& draw) {
    const int cx = static_cast<int>(std::lround(at_px.x())), cy = static_cast<int>(std::lround(at_px.y()));
    for (int y = std::max(0, cy - reach_px); y <= std::min(kHeightPx - 1, cy + reach_px); ++y)
      for (int x = std::max(0, cx - reach_px); x <= std::min(kWidthPx - 1, cx + reach_px); ++x)
        draw(x, y, dn_[static_cast<std::size_t>(y * kWidthPx + x)]);
  }
  std::vector<float> dn_;
};

/// Draws one camera's image. Lamps keep clear of the LEDs: what is hidden costs less to find.
Light Draw(const SyntheticCamera& camera, const std::vector<SyntheticBar>& bars, int lamps,
           std::mt19937& random) {
  std::uniform_real_distribution<double> x(0, kWidthPx), y(0, kHeightPx), radius(2, 30), sigma(1.2, 2.5);
  Light light;
  std::vector<Eigen::Vector2d> leds_px;
  for (const SyntheticBar& bar : bars) {
    for (const double place_m : bar.target.leds_m)
      leds_px.push_back(camera.Distorted(*camera.ProjectIdeal(bar.Point(place_m))));
  }
  for (int i = 0; i < lamps;) {
    const Eigen::Vector2d at_px(x(random), y(random));
    const double radius_px = radius(random);
    const bool hides = std::any_of(leds_px.begin(), leds_px.end(),
                                   [&](const auto& led) { return (led - at_px).norm() < radius_px + 12; });
    if (hides) continue;
    light.AddDisc(at_px, radius_px);
    ++i;
  }
  for (const Eigen::Vector2d& led : leds_px) light.AddLed(led, sigma(random));
  return light;
}

}  // namespace

base::CameraFrame ImagePair::Frame(base::Side side, base::TimeNs time_ns) const {
  base::CameraFrame frame;
  frame.stamp.side = side;
  frame.stamp.mid_exposure_ns = frame.stamp.last_packet_ns = time_ns;
  frame.image = {(side == base::Side::kLeft ? left : right).data(), kWidthPx, kHeightPx, kWidthPx, 8};
  return frame;
}

Stage MakeStage() {
  constexpr double kNearestM = 15;  // the models' trained range begins there
  return {support::ToedInRig().AsRig(),
          {support::ModelOf(support::SeedTargetOne(), kNearestM),
           support::ModelOf(support::SeedTargetTwo(), kNearestM)}};
}

std::vector<ImagePair> RenderPairs(int count, int lamps, unsigned seed) {
  std::mt19937 random(seed);
  const std::vector<float> noise = NoiseBank(random);
  const support::SyntheticRig rig = support::ToedInRig();
  std::uniform_real_distribution<double> distance_m(25, 60), lean(-0.3, 0.3);
  std::vector<ImagePair> pairs;
  for (int i = 0; i < count; ++i) {
    std::vector<SyntheticBar> bars;
    const Eigen::Vector3d aside(1.2, 0.8, 0);
    bars.push_back(SyntheticBar::At(support::SeedTargetOne(), support::Ahead(rig, distance_m(random)) - aside,
                                    Eigen::Vector3d(1, lean(random), lean(random))));
    bars.push_back(SyntheticBar::At(support::SeedTargetTwo(), support::Ahead(rig, distance_m(random)) + aside,
                                    Eigen::Vector3d(1, lean(random), lean(random))));
    ImagePair pair;
    pair.left = Draw(rig.left, bars, lamps, random).Expose(noise, random() % kNoiseLength);
    pair.right = Draw(rig.right, bars, lamps, random).Expose(noise, random() % kNoiseLength);
    pairs.push_back(std::move(pair));
  }
  return pairs;
}

}  // namespace adit::bench
