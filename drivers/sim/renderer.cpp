#include "drivers/sim/renderer.h"

#include <cmath>
#include <cstring>

#include "drivers/sim/noise.h"

namespace adit::sim {
namespace {

PixelBox ImageBox(const optics::CameraModel& camera) { return {0, 0, camera.width_px, camera.height_px}; }

double Apart(const Reception& a, const Reception& b) {
  return std::hypot(a.disc.x_px - b.disc.x_px, a.disc.y_px - b.disc.y_px);
}

}  // namespace

/// The sensor: light in, pixels out.
template <class Pixel>
struct Renderer::Develop {
  Develop(const Scene& scene, const PixelBox& box, base::Side side, NoiseSource source)
      : noise(scene.sensor, scene.fog.veil_dn) {
    if (source == NoiseSource::kBank) {
      const std::size_t pixels = static_cast<std::size_t>(box.x1) * static_cast<std::size_t>(box.y1);
      bank = std::make_unique<NoiseBank<Pixel>>(noise, pixels, 2 * scene.seed + static_cast<unsigned>(side));
    }
  }

  void Run(const Canvas& canvas, Random random, std::uint8_t* bytes) const {
    auto* const pixels = reinterpret_cast<Pixel*>(bytes);
    const PixelBox& box = canvas.Box();
    const auto width = static_cast<std::size_t>(box.x1);
    const std::size_t count = width * static_cast<std::size_t>(box.y1);
    if (bank) std::memcpy(pixels, bank->Draw(random), count * sizeof(Pixel));
    for (int r = 0; r < canvas.TileRows(); ++r) {
      for (int c = 0; c < canvas.TileColumns(); ++c) {
        const bool lit = canvas.Marked(c, r);
        if (!lit && bank) continue;
        const PixelBox tile = canvas.Tile(c, r);
        const auto across = static_cast<std::size_t>(tile.x1 - tile.x0);
        for (int y = tile.y0; y < tile.y1; ++y) {
          Pixel* const to = pixels + static_cast<std::size_t>(y) * width + tile.x0;
          if (lit)
            noise.Fill(random, canvas.Row(y) + tile.x0, to, across);
          else
            noise.FillDark(random, to, across);
        }
      }
    }
  }

  SensorNoise<Pixel> noise;
  std::unique_ptr<NoiseBank<Pixel>> bank;
};

/// The image of a light that never moves, at the scene's exposure_s.
struct Renderer::Still {
  explicit Still(const PixelBox& box) : image(box) {}
  Canvas image;
};

Renderer::Renderer(const World& world, base::Side side, NoiseSource source)
    : world_(world), side_(side), canvas_(ImageBox(world.Camera(side))), stills_(world.LightCount()) {
  const Scene& scene = world.GetScene();
  if (scene.sensor.bits > 8)
    develop16_ = std::make_unique<Develop<std::uint16_t>>(scene, canvas_.Box(), side, source);
  else
    develop8_ = std::make_unique<Develop<std::uint8_t>>(scene, canvas_.Box(), side, source);
}

Renderer::~Renderer() = default;

std::size_t Renderer::FrameBytes() const {
  const PixelBox& box = canvas_.Box();
  return static_cast<std::size_t>(box.x1) * static_cast<std::size_t>(box.y1) * (develop16_ ? 2 : 1);
}

void Renderer::AddDisc(const Reception& seen, double share, Canvas& canvas) const {
  const Scene& scene = world_.GetScene();
  Disc disc = seen.disc;
  disc.flux_dn *= share;
  double shown_share = 1;
  if (seen.shown == kAllShown) {
    world_.Painter().Add(disc, canvas);
  } else {
    // Each point of the disc stands for a small disc of its share of the area.
    const Disc part{0, 0, disc.radius_px / std::sqrt(kDiscPoints), disc.flux_dn / kDiscPoints};
    int shown = 0;
    for (std::size_t i = 0; i < kDiscPoints; ++i) {
      if ((seen.shown >> i & 1) == 0) continue;
      ++shown;
      const Eigen::Vector2d& at = DiscPoints()[i];
      world_.Painter().Add({disc.x_px + disc.radius_px * at.x(), disc.y_px + disc.radius_px * at.y(),
                            part.radius_px, part.flux_dn},
                           canvas);
    }
    shown_share = static_cast<double>(shown) / kDiscPoints;
  }
  Disc halo = disc;
  halo.flux_dn = disc.flux_dn * shown_share * scene.sensor.glare;
  if (scene.sensor.glare > 0) AddHalo(halo, scene.sensor.glare_sigma_px, canvas);
  // What the air takes from the direct way, a share of it arrives scattered.
  const double lost = std::expm1(scene.fog.per_m * seen.distance_m);
  halo.flux_dn = disc.flux_dn * shown_share * scene.fog.glow * lost;
  if (scene.fog.glow > 0) AddHalo(halo, scene.fog.glow_sigma_px, canvas);
}

const Canvas& Renderer::StillOf(std::size_t light, const Reception& seen) {
  std::unique_ptr<Still>& still = stills_[light];
  if (!still) {
    // Drawn once on a whole canvas to learn which tiles it lights, then kept on one of their size.
    Canvas whole(canvas_.Box());
    AddDisc(seen, 1, whole);
    PixelBox box{canvas_.Box().x1, canvas_.Box().y1, 0, 0};
    for (int r = 0; r < whole.TileRows(); ++r) {
      for (int c = 0; c < whole.TileColumns(); ++c) {
        if (!whole.Marked(c, r)) continue;
        const PixelBox tile = whole.Tile(c, r);
        box = {std::min(box.x0, tile.x0), std::min(box.y0, tile.y0), std::max(box.x1, tile.x1),
               std::max(box.y1, tile.y1)};
      }
    }
    still = std::make_unique<Still>(box);
    if (!box.Empty()) still->image.Add(whole, 1);
  }
  return still->image;
}

void Renderer::AddMoving(std::size_t light, double t_s, double factor) {
  constexpr double kStepPx = 0.25;    // of motion between two looks: a blur of that width is still a spot
  constexpr double kStandsPx = 0.05;  // a blur of that length widens a spot of 1.3 px by 0.01 %
  constexpr int kLooksMax = 32;
  const double exposure_s = factor * world_.GetScene().exposure_s;
  const auto start = world_.Receive(light, side_, t_s - exposure_s / 2);
  const auto middle = world_.Receive(light, side_, t_s);
  const auto end = world_.Receive(light, side_, t_s + exposure_s / 2);
  int looks = 3;
  if (start && middle && end) {
    // By way of the middle: something that shakes may be back at the end.
    const double way_px = Apart(*start, *middle) + Apart(*middle, *end);
    const bool stands = way_px < kStandsPx && start->shown == middle->shown && middle->shown == end->shown;
    looks = stands ? 1 : std::clamp(static_cast<int>(std::ceil(way_px / kStepPx)) | 1, looks, kLooksMax);
  }
  for (int i = 0; i < looks; ++i) {
    const double at_s = t_s + exposure_s * ((i + 0.5) / looks - 0.5);
    const auto seen = world_.Receive(light, side_, at_s);
    if (seen && seen->shown != 0) AddDisc(*seen, factor / looks, canvas_);
  }
}

void Renderer::Expose(std::uint64_t trigger) {
  const double t_s = world_.MidExposureS(trigger);
  const double factor = world_.ExposureFactor(t_s);
  canvas_.Clear();
  for (std::size_t i = 0; i < world_.LightCount(); ++i) {
    if (!world_.AtRest(i)) {
      AddMoving(i, t_s, factor);
      continue;
    }
    const auto seen = world_.Receive(i, side_, t_s);
    if (!seen || seen->shown == 0) continue;
    if (seen->shown == kAllShown)
      canvas_.Add(StillOf(i, *seen), static_cast<float>(factor));
    else
      AddDisc(*seen, factor, canvas_);
  }
}

void Renderer::Render(std::uint64_t trigger, std::uint8_t* pixels) {
  Expose(trigger);
  const Random random(world_.GetScene().seed, 2 * trigger + static_cast<unsigned>(side_));
  if (develop16_)
    develop16_->Run(canvas_, random, pixels);
  else
    develop8_->Run(canvas_, random, pixels);
}

std::vector<float> Renderer::Light(std::uint64_t trigger) {
  Expose(trigger);
  std::vector<float> light;
  for (int y = 0; y < canvas_.Box().y1; ++y)
    light.insert(light.end(), canvas_.Row(y), canvas_.Row(y) + canvas_.Box().x1);
  return light;
}

}  // namespace adit::sim
