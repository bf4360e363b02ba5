#include "firmware/identify/model.h"

#include <cmath>
#include <iomanip>
#include <sstream>

#include "firmware/base/yaml.h"

namespace adit::identify {
namespace {

using base::YamlReader;

constexpr double kSmallestGapM = 0.010;  // below it, diffuse spheres touch
constexpr double kAsymmetryMin = 0.01;   // outer gaps closer than 1 % of the length do not tell the direction
constexpr base::Range kPlaceM{0, 20};    // the longest boom a machine carries
constexpr base::Range kEpicenterM{-50, 50};
constexpr base::Range kLedDiameterM{0.001, 0.5};
constexpr base::Range kP2{2.0, 2.8};  // the invariant's range, seed 2.2.2.1
constexpr double kLongestImagePx = 20000;

base::Target ReadTarget(YamlReader& in) {
  base::Target target;
  target.name = in.Text("name");
  if (target.name.find_first_of(",\"\n") != std::string::npos)
    in.Refuse("name", "must not hold commas, quotes or line ends");
  const auto leds_m = in.Numbers("leds_m", base::kLedCount, kPlaceM);
  target.epicenter_m = in.Number("epicenter_m", kEpicenterM);
  target.led_diameter_m = in.NumberOr("led_diameter_m", target.led_diameter_m, kLedDiameterM);
  if (!in.Ok()) return target;
  for (std::size_t i = 0; i < leds_m.size(); ++i) {
    target.leds_m[i] = leds_m[i];
    if (i == 0 && leds_m[0] != 0)
      in.Refuse("leds_m", "must start at 0, starts at " + std::to_string(leds_m[0]));
    if (i > 0 && leds_m[i] - leds_m[i - 1] < kSmallestGapM) {
      in.Refuse("leds_m", "must ascend by at least 0.010 m; LED " + std::to_string(i + 1) + " follows LED " +
                              std::to_string(i) + " by " + std::to_string(leds_m[i] - leds_m[i - 1]) + " m");
    }
  }
  const double first_m = leds_m[1] - leds_m[0], last_m = leds_m[3] - leds_m[2];
  if (std::abs(first_m - last_m) < kAsymmetryMin * leds_m[3]) {
    in.Refuse("leds_m",
              "has outer gaps of " + std::to_string(first_m) + " and " + std::to_string(last_m) +
                  " m; they must differ by at least 1 % of the length, or the direction cannot be told");
  }
  return target;
}

}  // namespace

base::Result<base::Target> LoadTarget(const std::string& path) {
  auto in = YamlReader::OpenFile(path);
  if (!in) return in.error();
  const base::Target target = ReadTarget(*in);
  if (auto done = in->Finish(); !done) return done.error();
  return target;
}

std::string FormatTarget(const base::Target& target) {
  std::ostringstream text;
  text << std::setprecision(12) << "name: " << base::Quoted(target.name) << "\nleds_m: [" << target.leds_m[0]
       << ", " << target.leds_m[1] << ", " << target.leds_m[2] << ", " << target.leds_m[3]
       << "]\nepicenter_m: " << target.epicenter_m << "\nled_diameter_m: " << target.led_diameter_m << "\n";
  return text.str();
}

base::Result<Model> LoadModel(const std::string& path) {
  auto in = YamlReader::OpenFile(path);
  if (!in) return in.error();
  Model model;
  model.target = ReadTarget(*in);
  const auto p2 = in->Numbers("p2_range", 2, kP2);
  model.collinearity_max = in->Number("collinearity_max", {0, 1});
  const auto length = in->Numbers("length_range_px", 2, {0, kLongestImagePx});
  model.trained_on = in->TextOr("trained_on", "");
  model.p2_min = p2[0], model.p2_max = p2[1];
  model.length_min_px = length[0], model.length_max_px = length[1];
  if (in->Ok() && !(p2[0] < p2[1])) in->Refuse("p2_range", "must ascend");
  if (in->Ok() && !(length[0] < length[1])) in->Refuse("length_range_px", "must ascend");
  if (auto done = in->Finish(); !done) return done.error();
  return model;
}

std::string FormatModel(const Model& model) {
  std::ostringstream text;
  text << FormatTarget(model.target) << std::setprecision(9) << "p2_range: [" << model.p2_min << ", "
       << model.p2_max << "]\ncollinearity_max: " << model.collinearity_max
       << "  # rms distance from the line / length\nlength_range_px: [" << model.length_min_px << ", "
       << model.length_max_px << "]\n";
  if (!model.trained_on.empty()) text << "trained_on: " << base::Quoted(model.trained_on) << "\n";
  return text.str();
}

}  // namespace adit::identify
