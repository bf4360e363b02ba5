#include "drivers/sim/live_scene.h"

namespace adit::sim {

base::Result<std::unique_ptr<LiveScene>> LiveScene::Open(const std::string& path, NoiseSource source) {
  auto scene = LoadScene(path);
  if (!scene) return scene.error();
  return std::make_unique<LiveScene>(std::move(*scene), source);
}

LiveScene::LiveScene(Scene scene, NoiseSource source)
    : world_(std::move(scene)),
      left_(world_, base::Side::kLeft, source),
      right_(world_, base::Side::kRight, source) {}

}  // namespace adit::sim
