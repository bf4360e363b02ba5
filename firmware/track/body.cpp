#include "firmware/track/body.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "firmware/base/yaml.h"
#include "firmware/track/bar_place.h"

namespace adit::track {

namespace {

using base::YamlReader;
using Eigen::Vector3d;

constexpr base::Range kPlaceM{-100, 100};     // no machine is longer
constexpr base::Range kSigmaM{0.00001, 0.1};  // from an interferometer to a folding rule
constexpr double kDirectionMin = 1e-3;        // shorter lists of three are rounded zeros
// A bar this far off another's line turns the body visibly: 50 mm.
constexpr double kAsideMinM = 0.05;

Vector3d ReadVector(YamlReader& in, const std::string& key) {
  const auto numbers = in.Numbers(key, 3, kPlaceM);
  return in.Ok() ? Vector3d(numbers[0], numbers[1], numbers[2]) : Vector3d(Vector3d::Zero());
}

BodyBar ReadBar(YamlReader& in, const std::vector<base::Target>& targets) {
  BodyBar bar;
  const std::string name = in.Text("name");
  const auto target =
      std::find_if(targets.begin(), targets.end(), [&name](const base::Target& t) { return t.name == name; });
  bar.led1_t_m = ReadVector(in, "at_m");
  const Vector3d direction = ReadVector(in, "direction");
  if (!in.Ok()) return bar;
  if (target == targets.end()) {
    in.Refuse("name", "is '" + name + "', which is the name of no model");
    return bar;
  }
  if (!(direction.norm() > kDirectionMin)) {
    in.Refuse("direction", "has no length; it must point from LED 1 to LED 4");
    return bar;
  }
  bar.target = static_cast<std::uint8_t>(target - targets.begin());
  bar.direction_t = direction.normalized();
  bar.centre_m = CentreM(*target);
  bar.length_m = target->LengthM();
  return bar;
}

/// Whether all bars lie on the line of the first one.
bool OnOneLine(const Body& body) {
  const BodyBar& first = body.bars[0];
  return std::all_of(body.bars.begin(), body.bars.end(), [&first](const BodyBar& bar) {
    const Vector3d led4_t_m = bar.led1_t_m + bar.length_m * bar.direction_t;
    const auto aside_m = [&first](const Vector3d& point_t_m) {
      return first.direction_t.cross(point_t_m - first.led1_t_m).norm();
    };
    return std::max(aside_m(bar.led1_t_m), aside_m(led4_t_m)) < kAsideMinM;
  });
}

void ReadBars(YamlReader& in, const std::vector<base::Target>& targets, Body& body) {
  auto items = in.Items("targets");
  if (in.Ok() && (items.size() < 2 || items.size() > kMaxBodyBars)) {
    in.Refuse("targets", "has " + std::to_string(items.size()) + "; from 2 to " +
                             std::to_string(kMaxBodyBars) + " give a body its six degrees of freedom");
    return;
  }
  for (YamlReader& item : items) {
    const BodyBar bar = ReadBar(item, targets);
    if (!in.Ok()) return;
    for (const BodyBar& other : body.bars) {
      if (other.target == bar.target)
        item.Refuse("name", "is '" + targets[bar.target].name + "' for the second time");
    }
    body.bars.push_back(bar);
  }
  if (in.Ok() && OnOneLine(body))
    in.Refuse("targets", "lie within 50 mm of one line; they show nothing of the turn around it");
}

}  // namespace

Vector3d Body::MiddleM() const {
  Vector3d sum_m = Vector3d::Zero();
  for (const BodyBar& bar : bars) sum_m += bar.CentreM();
  return sum_m / static_cast<double>(bars.size());
}

base::Result<Body> LoadBody(const std::string& path, const std::vector<base::Target>& targets) {
  auto in = YamlReader::OpenFile(path);
  if (!in) return in.error();
  Body body;
  body.name = in->Text("name");
  if (body.name.find_first_of(",\"\n") != std::string::npos)
    in->Refuse("name", "must not hold commas, quotes or line ends");
  body.sigma_m = in->NumberOr("sigma_m", body.sigma_m, kSigmaM);
  ReadBars(*in, targets, body);
  if (auto done = in->Finish(); !done) return done.error();
  return body;
}

base::Result<std::vector<Body>> LoadBodies(const std::vector<std::string>& paths,
                                           const std::vector<base::Target>& targets, std::size_t at_most) {
  std::vector<Body> bodies;
  for (const std::string& path : paths) {
    auto body = LoadBody(path, targets);
    if (!body) return body.error();
    const auto is_named = [&body](const auto& other) { return other.name == body->name; };
    const bool taken = std::any_of(targets.begin(), targets.end(), is_named) ||
                       std::any_of(bodies.begin(), bodies.end(), is_named);
    if (taken) {
      return base::Error{base::ErrorCode::kOutOfRange, path + ": name",
                         "is '" + body->name + "', as a target or another body; names must differ"};
    }
    bodies.push_back(std::move(*body));
  }
  if (bodies.size() > at_most) {
    return base::Error{base::ErrorCode::kOutOfRange, "bodies",
                       "there are " + std::to_string(bodies.size()) + " beside the models; at most " +
                           std::to_string(at_most) + " are allowed"};
  }
  return bodies;
}

}  // namespace adit::track
