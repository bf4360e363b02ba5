#include "tests/bench/bench_frames.h"

#include <sys/mman.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <random>

#include "firmware/base/require.h"
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
  explicit Light(const Size& size) : size_(size), dn_(size.Bytes(), static_cast<float>(kBackgroundDn)) {}

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
  Image Expose(const std::vector<float>& noise, std::size_t offset) const {
    Image image(size_);
    for (std::size_t i = 0; i < dn_.size(); ++i) {
      const float value = dn_[i] + noise[(offset + i) % kNoiseLength];
      image.Pixels()[i] = static_cast<std::uint8_t>(std::clamp(std::lround(value), 0L, 255L));
    }
    return image;
  }

 private:
  template <typename Draw>
  void Each(const Eigen::Vector2d& at_px, int reach_px, const Draw& draw) {
    const int cx = static_cast<int>(std::lround(at_px.x())), cy = static_cast<int>(std::lround(at_px.y()));
    for (int y = std::max(0, cy - reach_px); y <= std::min(size_.height_px - 1, cy + reach_px); ++y)
      for (int x = std::max(0, cx - reach_px); x <= std::min(size_.width_px - 1, cx + reach_px); ++x)
        draw(x, y, dn_[static_cast<std::size_t>(y * size_.width_px + x)]);
  }
  Size size_;
  std::vector<float> dn_;
};

std::vector<Eigen::Vector2d> LedsIn(const SyntheticCamera& camera, const std::vector<SyntheticBar>& bars) {
  std::vector<Eigen::Vector2d> leds_px;
  for (const SyntheticBar& bar : bars) {
    for (const double place_m : bar.target.leds_m)
      leds_px.push_back(camera.Distorted(*camera.ProjectIdeal(bar.Point(place_m))));
  }
  return leds_px;
}

/// Draws one camera's image. Lamps keep clear of the LEDs: what is hidden costs less to find.
Light Draw(const SyntheticCamera& camera, const std::vector<SyntheticBar>& bars, int lamps,
           std::mt19937& random) {
  std::uniform_real_distribution<double> x(0, kWidthPx), y(0, kHeightPx), radius(2, 30), sigma(1.2, 2.5);
  Light light(Size{});
  const std::vector<Eigen::Vector2d> leds_px = LedsIn(camera, bars);
  for (int i = 0; i < lamps;) {
    const Eigen::Vector2d at_px(x(random), y(random));
    const double radius_px = radius(random);
    const bool hides = std::any_of(leds_px.begin(), leds_px.end(),
                                   [&](const auto& led) { return (led - at_px).norm() < radius_px + 12; });
    if (hides) continue;
    light.AddDisc(at_px, radius_px);
    ++i;
  }
  // One lens shows the LEDs of one bar alike.
  double sigma_px = 0;
  for (std::size_t i = 0; i < leds_px.size(); ++i) {
    if (i % base::kLedCount == 0) sigma_px = sigma(random);
    light.AddLed(leds_px[i], sigma_px);
  }
  return light;
}

/// Two bars as the seed's, and two that differ from them.
std::vector<base::Target> Targets() {
  std::vector<base::Target> targets{support::SeedTargetOne(), support::SeedTargetTwo()};
  targets.push_back({"three", {0, 0.50, 0.80, 1.50}, 0.75});
  targets.push_back({"four", {0, 0.40, 1.20, 1.50}, 0.75});
  return targets;
}

ImagePair Expose(const support::SyntheticRig& rig, const std::vector<SyntheticBar>& bars, int lamps,
                 const std::vector<float>& noise, std::mt19937& random) {
  ImagePair pair;
  pair.left = Draw(rig.left, bars, lamps, random).Expose(noise, random() % kNoiseLength);
  pair.right = Draw(rig.right, bars, lamps, random).Expose(noise, random() % kNoiseLength);
  return pair;
}

constexpr std::size_t kHugeBytes = 2U << 20;

/// A rig whose cameras have images of that size.
support::SyntheticRig RigOf(const Size& size) {
  support::SyntheticRig rig = support::ToedInRig();
  for (SyntheticCamera* const camera : {&rig.left, &rig.right}) {
    camera->width_px = size.width_px, camera->height_px = size.height_px;
    camera->cu_px = (size.width_px - 1) / 2.0, camera->cv_px = (size.height_px - 1) / 2.0;
  }
  return rig;
}

/// Bars of 1.5 m whose gaps all differ by 3 cm or more.
std::vector<base::Target> DifferentTargets(std::size_t count) {
  std::vector<base::Target> targets;
  for (int first_cm = 15; first_cm < 75 && targets.size() < count; first_cm += 6) {
    for (int second_cm = first_cm + 15; second_cm < 130 - first_cm && targets.size() < count; second_cm += 9)
      targets.push_back(
          {"t" + std::to_string(targets.size()), {0, first_cm * 0.01, second_cm * 0.01, 1.5}, 0});
  }
  ADIT_REQUIRE(targets.size() == count);
  return targets;
}

/// One camera's image of a crowd. Spots keep clear of the LEDs.
Light DrawCrowd(const SyntheticCamera& camera, const std::vector<SyntheticBar>& bars, int spots,
                std::mt19937& random) {
  constexpr double kClearPx = 12, kSpotSigmaPx = 1.5;
  std::uniform_real_distribution<double> x(0, camera.width_px), y(0, camera.height_px);
  Light light({camera.width_px, camera.height_px});
  const std::vector<Eigen::Vector2d> leds_px = LedsIn(camera, bars);
  for (int i = 0; i < spots;) {
    const Eigen::Vector2d at_px(x(random), y(random));
    if (std::any_of(leds_px.begin(), leds_px.end(),
                    [&](const auto& led) { return (led - at_px).norm() < kClearPx; }))
      continue;
    light.AddLed(at_px, kSpotSigmaPx);
    ++i;
  }
  for (const Eigen::Vector2d& led : leds_px) light.AddLed(led, kSpotSigmaPx);
  return light;
}

}  // namespace

void Image::Unmap::operator()(std::uint8_t* memory) const { std::free(memory); }

Image::Image(const Size& size, Pages pages) : size_(size) {
  const std::size_t mapped_bytes = (size.Bytes() + kHugeBytes - 1) / kHugeBytes * kHugeBytes;
  memory_.reset(static_cast<std::uint8_t*>(std::aligned_alloc(kHugeBytes, mapped_bytes)));
  ADIT_REQUIRE(memory_ != nullptr);
  // Said both ways: some systems give huge pages unasked.
  const int advice = pages == Pages::kHuge ? MADV_HUGEPAGE : MADV_NOHUGEPAGE;
  ADIT_REQUIRE(madvise(memory_.get(), mapped_bytes, advice) == 0);
  std::memset(memory_.get(), 0, mapped_bytes);
}

Image::Image(const Image& other, Pages pages) : Image(other.size_, pages) {
  std::ranges::copy(other.Pixels(), memory_.get());
}

std::vector<ImagePair> InPages(const std::vector<ImagePair>& pairs, Pages pages) {
  std::vector<ImagePair> copies;
  for (const ImagePair& pair : pairs) copies.push_back({Image(pair.left, pages), Image(pair.right, pages)});
  return copies;
}

base::CameraFrame ImagePair::Frame(base::Side side, base::TimeNs time_ns) const {
  base::CameraFrame frame;
  frame.stamp.side = side;
  frame.stamp.mid_exposure_ns = frame.stamp.last_packet_ns = time_ns;
  const Image& image = side == base::Side::kLeft ? left : right;
  const Size& size = image.GetSize();
  frame.image = {image.Pixels().data(), size.width_px, size.height_px, size.width_px, 8};
  return frame;
}

Stage MakeStage(std::size_t targets) {
  constexpr double kNearestM = 15;  // the models' trained range begins there
  Stage stage{support::ToedInRig().AsRig(), {}};
  for (std::size_t i = 0; i < targets; ++i) stage.models.push_back(support::ModelOf(Targets()[i], kNearestM));
  return stage;
}

std::vector<ImagePair> RenderDrive(int count, std::size_t bars, int lamps, unsigned seed) {
  std::mt19937 random(seed);
  const std::vector<float> noise = NoiseBank(random);
  const support::SyntheticRig rig = support::ToedInRig();
  std::vector<ImagePair> pairs;
  for (int i = 0; i < count; ++i) {
    const double turn = 2 * M_PI * i / count;
    std::vector<SyntheticBar> driven;
    for (std::size_t t = 0; t < bars; ++t) {
      const auto k = static_cast<double>(t);
      const Eigen::Vector3d aside((t % 2 == 0 ? -1.3 : 1.3) + 0.3 * std::sin(turn), 0.7 * (k - 1.5), 0);
      driven.push_back(SyntheticBar::At(Targets()[t],
                                        support::Ahead(rig, 32 + 6 * k + std::sin(turn + k)) + aside,
                                        Eigen::Vector3d(1, 0.2 * std::sin(turn), 0.1 * k - 0.1)));
    }
    pairs.push_back(Expose(rig, driven, lamps, noise, random));
  }
  return pairs;
}

Stage MakeStage(const Crowd& crowd) {
  constexpr double kNearestM = 15;
  Stage stage{RigOf(crowd.size).AsRig(), {}};
  for (const base::Target& target : DifferentTargets(crowd.targets))
    stage.models.push_back(support::ModelOf(target, kNearestM));
  return stage;
}

std::vector<ImagePair> RenderCrowd(const Crowd& crowd, int count, unsigned seed) {
  constexpr std::size_t kColumns = 4;
  constexpr double kAheadM = 45, kStepAcrossM = 3, kStepDownM = 1;
  std::mt19937 random(seed);
  const std::vector<float> noise = NoiseBank(random);
  const support::SyntheticRig rig = RigOf(crowd.size);
  const std::vector<base::Target> targets = DifferentTargets(crowd.targets);
  const std::size_t columns = std::min(targets.size(), kColumns);
  const std::size_t rows = (targets.size() + kColumns - 1) / kColumns;
  std::uniform_real_distribution<double> lean(-0.1, 0.1);
  std::vector<ImagePair> pairs;
  for (int i = 0; i < count; ++i) {
    std::vector<SyntheticBar> bars;
    for (std::size_t t = 0; t < targets.size(); ++t) {
      const double column = static_cast<double>(t % kColumns), row = static_cast<double>(t / kColumns);
      const Eigen::Vector3d aside(kStepAcrossM * (column - 0.5 * static_cast<double>(columns - 1)),
                                  kStepDownM * (row - 0.5 * static_cast<double>(rows - 1)), 0);
      bars.push_back(SyntheticBar::At(targets[t], support::Ahead(rig, kAheadM) + aside,
                                      Eigen::Vector3d(1, lean(random), lean(random))));
    }
    ImagePair pair;
    pair.left = DrawCrowd(rig.left, bars, crowd.spots, random).Expose(noise, random() % kNoiseLength);
    pair.right = DrawCrowd(rig.right, bars, crowd.spots, random).Expose(noise, random() % kNoiseLength);
    pairs.push_back(std::move(pair));
  }
  return pairs;
}

}  // namespace adit::bench
