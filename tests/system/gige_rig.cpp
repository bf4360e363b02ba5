#include "tests/system/gige_rig.h"

#include <array>
#include <chrono>

namespace adit::test {
namespace {

constexpr int kWidthPx = 320, kHeightPx = 240;
constexpr std::size_t kPixels = static_cast<std::size_t>(kWidthPx) * kHeightPx;
constexpr std::int64_t kTakeLimitNs = 10 * base::kNsPerS;
constexpr unsigned kNumberBits = 24;
constexpr std::size_t kNumberPixels = kNumberBits / 8;

/// Pixel `i` of a frame: first the two numbers, 8 bits a pixel, then a pattern that changes everywhere.
std::uint32_t Pixel(std::size_t i, std::uint64_t drawn, std::uint64_t trigger, int bits) {
  if (i < kNumberPixels) return (drawn >> (8 * i)) & 0xFF;
  if (i < 2 * kNumberPixels) return (trigger >> (8 * (i - kNumberPixels))) & 0xFF;
  return static_cast<std::uint32_t>(drawn * 37 + i * 31 + (i >> 8)) & ((1U << bits) - 1);
}

/// Little-endian, as cameras send it.
std::uint32_t At(const std::uint8_t* pixels, std::size_t i, int bits) {
  if (bits == 8) return pixels[i];
  return static_cast<std::uint32_t>(pixels[2 * i]) | static_cast<std::uint32_t>(pixels[2 * i + 1]) << 8;
}

std::uint64_t NumberAt(const std::uint8_t* pixels, std::size_t first, int bits) {
  std::uint64_t number = 0;
  for (std::size_t i = 0; i < kNumberPixels; ++i)
    number |= static_cast<std::uint64_t>(At(pixels, first + i, bits)) << (8 * i);
  return number;
}

sim::GigeOptions CameraOf(const RigOptions& options) {
  sim::GigeOptions camera = options.camera;
  camera.frame_bytes = kPixels * (options.bits > 8 ? 2 : 1);
  return camera;
}

aravis::AravisSettings DriverOf(const RigOptions& options) {
  aravis::AravisSettings driver = options.driver;
  driver.bits = options.bits;
  return driver;
}

}  // namespace

base::TimeNs HoldingClock::Now() const {
  const base::TimeNs now_ns = linux::SystemClock().Now();
  if (delay_ns_ > 0 && std::this_thread::get_id() != free_)
    std::this_thread::sleep_for(std::chrono::nanoseconds(delay_ns_));
  return now_ns;
}

RigOptions SmallRig() {
  RigOptions options;
  options.camera.identity.width_px = kWidthPx;
  options.camera.identity.height_px = kHeightPx;
  options.camera.trigger.start_ns = linux::SystemClock().Now();
  options.driver.device = "127.0.0.1";
  options.driver.width_px = kWidthPx;
  options.driver.height_px = kHeightPx;
  options.driver.packet_size = 1500;
  options.driver.packet_socket = false;
  return options;
}

GigeRig::GigeRig(const RigOptions& options)
    : clock(options.receiver_delay_ns),
      camera(CameraOf(options),
             [this](std::uint64_t trigger, std::uint8_t* pixels) { Draw(trigger, pixels); }),
      driver(DriverOf(options), clock),
      options_(options) {}

bool GigeRig::Start() {
  auto started = camera.Start();
  if (started) started = driver.Start();
  if (!started) failure_ = started.error().Line();
  return static_cast<bool>(started);
}

void GigeRig::Draw(std::uint64_t trigger, std::uint8_t* pixels) {
  const std::uint64_t drawn = drawn_++;
  for (std::size_t i = 0; i < kPixels; ++i) {
    const std::uint32_t value = Pixel(i, drawn, trigger, options_.bits);
    if (options_.bits == 8) {
      pixels[i] = static_cast<std::uint8_t>(value);
    } else {
      pixels[2 * i] = static_cast<std::uint8_t>(value);
      pixels[2 * i + 1] = static_cast<std::uint8_t>(value >> 8);
    }
  }
}

Seen GigeRig::Look(const base::CameraFrame& frame) const {
  Seen seen;
  seen.stamp = frame.stamp;
  if (frame.stamp.status != base::FrameStatus::kOk) return seen;
  const int bits = options_.bits;
  const std::uint8_t* const pixels = frame.image.data;
  seen.drawn = NumberAt(pixels, 0, bits);
  seen.trigger = NumberAt(pixels, kNumberPixels, bits);
  seen.right = frame.image.width_px == kWidthPx && frame.image.height_px == kHeightPx &&
               frame.image.bits == bits && frame.image.stride_bytes == kWidthPx * (bits > 8 ? 2 : 1);
  for (std::size_t i = 0; i < kPixels && seen.right; ++i)
    seen.right = At(pixels, i, bits) == Pixel(i, seen.drawn, seen.trigger, bits);
  return seen;
}

std::vector<Seen> GigeRig::Take(std::size_t count) {
  std::vector<Seen> seen;
  const std::int64_t until_ns = linux::MonotonicNs() + kTakeLimitNs;
  while (seen.size() < count && linux::MonotonicNs() < until_ns) {
    base::CameraFrame frame;
    if (Wait(frame) != hal::WaitOutcome::kFrame) continue;
    seen.push_back(Look(frame));
    driver.Release(frame);
  }
  return seen;
}

std::vector<std::uint8_t> GigeRig::Memory(std::uint32_t address, std::uint8_t bytes) {
  std::array<std::uint8_t, 16> packet{0x42, 1, 0, 0x84, 0, 8, 0, 1};
  sim::WriteU32(packet, 8, address);
  packet[15] = bytes;
  std::vector<std::uint8_t> reply = camera.Reply(packet, {});
  constexpr std::ptrdiff_t kBeforeBytes = 12;  // header and address
  if (reply.size() < kBeforeBytes) return {};
  return {reply.begin() + kBeforeBytes, reply.end()};
}

}  // namespace adit::test
