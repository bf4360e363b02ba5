// Damaged settings through every loader: whatever a file holds, the answer is a value that survives being
// written and read again, or one line that names the file.
#include <sys/mman.h>
#include <unistd.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "firmware/base/require.h"
#include "firmware/config/box_config.h"
#include "firmware/identify/model.h"
#include "firmware/optics/rig.h"

namespace {

/// A file in memory, so that the loaders run as they do on a disk.
class MemoryFile {
 public:
  MemoryFile() : descriptor_(memfd_create("settings", 0)) { ADIT_REQUIRE(descriptor_ >= 0); }
  void Write(std::string_view text) const {
    ADIT_REQUIRE(ftruncate(descriptor_, 0) == 0);
    ADIT_REQUIRE(pwrite(descriptor_, text.data(), text.size(), 0) == static_cast<ssize_t>(text.size()));
  }
  std::string Path() const { return "/proc/self/fd/" + std::to_string(descriptor_); }

 private:
  int descriptor_;
};

template <class T>
void CheckLoader(const MemoryFile& file, adit::base::Result<T> (*load)(const std::string&),
                 std::string (*format)(const T&)) {
  const auto value = load(file.Path());
  if (!value) {
    const std::string line = value.error().Line();
    ADIT_REQUIRE(line.rfind(file.Path(), 0) == 0 && line.size() < 2000);
    for (const char c : line) ADIT_REQUIRE(static_cast<unsigned char>(c) >= 0x20);
    return;
  }
  const std::string text = format(*value);
  file.Write(text);
  const auto again = load(file.Path());
  ADIT_REQUIRE(again);
  ADIT_REQUIRE(format(*again) == text);
}

struct Kind {
  std::string_view example;
  void (*check)(const MemoryFile&);
};

using adit::config::BoxConfig;

const std::array<Kind, 5> kKinds{{
    {"cam0:\n  camera_model: pinhole\n  intrinsics: [3400, 3401, 700, 512]\n  distortion_model: radtan\n"
     "  distortion_coeffs: [-0.2, 0.1, 0, 0]\n  resolution: [1400, 1024]\n"
     "cam1:\n  camera_model: pinhole\n  intrinsics: [3400, 3401, 700, 512]\n  distortion_model: radtan\n"
     "  distortion_coeffs: [-0.2, 0.1, 0, 0]\n  resolution: [1400, 1024]\n  T_cn_cnm1:\n"
     "  - [1, 0, 0, -9]\n  - [0, 1, 0, 0]\n  - [0, 0, 1, 0]\n  - [0, 0, 0, 1]\ncalibration_id: \"id\"\n",
     [](const MemoryFile& file) { CheckLoader(file, adit::optics::LoadRig, adit::optics::FormatRig); }},
    {"camera_model: pinhole\nintrinsics: [3400, 3401, 700, 512]\ndistortion_model: radial-tangential\n"
     "distortion_coefficients: [-0.2, 0.1, 0, 0]\nresolution: [1400, 1024]\nT_BS: {cols: 4}\n",
     [](const MemoryFile& file) { CheckLoader(file, adit::optics::LoadCamera, adit::optics::FormatCamera); }},
    {"%YAML:1.0\n---\nimage_width: 1400\nimage_height: 1024\ncamera_matrix: !!opencv-matrix\n   rows: 3\n"
     "   cols: 3\n   dt: d\n   data: [ 3400., 0., 700., 0., 3400., 511., 0., 0., 1. ]\n"
     "distortion_coefficients: !!opencv-matrix\n   rows: 1\n   cols: 4\n   dt: d\n   data: [ 0.1, 0., 0., 0. "
     "]\n",
     [](const MemoryFile& file) { CheckLoader(file, adit::optics::LoadCamera, adit::optics::FormatCamera); }},
    {"name: bar\nleds_m: [0.0, 0.25, 0.65, 1.50]\nepicenter_m: -0.5\nled_diameter_m: 0.04\n"
     "p2_range: [2.1, 2.2]\ncollinearity_max: 0.002\nlength_range_px: [30, 400]\ntrained_on: \"geometry\"\n",
     [](const MemoryFile& file) {
       CheckLoader(file, adit::identify::LoadModel, adit::identify::FormatModel);
     }},
    {"rig: rig.yaml\nmodels: [a.yaml, b.yaml]\ncameras:\n  left: {device: 10.0.0.1}\n"
     "  right: {device: 10.0.0.2}\n",
     [](const MemoryFile& file) {
       CheckLoader(file, adit::config::LoadBoxConfig, adit::config::FormatBoxConfig);
     }},
}};

/// What YAML is made of.
constexpr std::array<std::string_view, 28> kTokens{
    "[",   "]",   "{",  "}", ": ", ", ", "- ",   "\n",   "\n  ",  "#",  "&a ", "*a",   "!!", "? ",
    "---", "|\n", "\"", "'", "\\", "~",  ".nan", ".inf", "1e999", "-1", "0",   "<<: ", "\t", "\xC3\xA4"};

/// Applies `script` to `text`: an operation, a place (two bytes) and an argument each.
std::string Damage(std::string text, std::string_view script) {
  for (; script.size() >= 4 && !text.empty(); script.remove_prefix(4)) {
    const auto byte = [&script](std::size_t i) {
      return static_cast<std::size_t>(static_cast<unsigned char>(script[i]));
    };
    const std::size_t at = (byte(1) * 256 + byte(2)) % text.size();
    const std::size_t line_end = text.find('\n', at);
    switch (byte(0) % 5) {
      case 0:
        text[at] = script[3];
        break;
      case 1:
        text.erase(at, byte(3) % 16 + 1);
        break;
      case 2:
        text.insert(at, kTokens[byte(3) % kTokens.size()]);
        break;
      case 3:
        text.replace(at, 1, kTokens[byte(3) % kTokens.size()]);
        break;
      default:
        text.insert(at, text.substr(at, line_end - at));
        break;
    }
    if (text.size() > 4000) break;  // doubling lines grows without end
  }
  return text;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const MemoryFile file;
  if (size == 0) return 0;
  const Kind& kind = kKinds[data[0] % 64 % kKinds.size()];
  const std::string_view rest(reinterpret_cast<const char*>(data) + 1, size - 1);
  constexpr std::size_t kShortScript = 40;  // ten changes: a long one leaves nothing of the example
  const bool raw = data[0] >= 0xC0;
  file.Write(raw ? std::string(rest) : Damage(std::string(kind.example), rest.substr(0, kShortScript)));
  kind.check(file);
  return 0;
}
