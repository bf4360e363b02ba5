#include "host/georeferencing.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <set>
#include <sstream>

namespace adit::host {
namespace {

using base::Error;
using base::ErrorCode;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using pipeline::TrackRow;

Error RefuseAt(const std::string& where, const std::string& detail) {
  return {ErrorCode::kOutOfRange, where, detail};
}

bool Holds(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

std::string TargetsOf(const std::vector<TrackRow>& track) {
  std::set<std::string> names;
  for (const TrackRow& row : track) names.insert(row.target);
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text.empty() ? "no target" : text;
}

/// The point of the rig that a control point is, if any.
base::Result<std::optional<RigPointName>> RigPointOf(const std::string& control,
                                                     const std::vector<TrackRow>& track,
                                                     const MatchOptions& options) {
  const auto pair = options.pairs.find(control);
  const auto found = FindRigPoint(track, pair == options.pairs.end() ? control : pair->second);
  if (!found && pair != options.pairs.end()) {
    return RefuseAt("--pair " + control + "=" + pair->second, "names no target or LED of the track; it has " +
                                                                  TargetsOf(track) + ", and LEDs are named " +
                                                                  "TARGET.1 to TARGET.4");
  }
  return found;
}

base::Result<MatchedPoint> Match(const ControlFile& control, const ControlPoint& point,
                                 const std::vector<TrackRow>& track, const RigPointName& name) {
  if (const auto only = control.Find(point.name); !only) return only.error();
  const auto position_m = control.PositionOf(point);
  if (!position_m) return position_m.error();
  const auto average = AverageRigPoint(track, name);
  if (!average) return average.error();
  MatchedPoint matched;
  matched.common.name = point.name;
  matched.common.rig_b_m = average->mean_b_m;
  matched.common.rig_covariance_m2 = average->sigma_m.cwiseAbs2().asDiagonal();
  matched.common.control_s_m = *position_m;
  matched.rig_name = name.Text();
  matched.rows = average->rows;
  return matched;
}

/// Everything that the command line names must be in the file.
base::Result<void> CheckNames(const ControlFile& control, const MatchOptions& options) {
  const auto check = [&control](const std::string& name, const std::string& option) -> base::Result<void> {
    const auto found = control.Find(name);
    if (!found) return found.error();
    if (*found == nullptr) return RefuseAt(option, "is no point of " + control.path);
    return {};
  };
  for (const auto& [name, rig_point] : options.pairs) {
    if (auto known = check(name, "--pair " + name + "=" + rig_point); !known) return known;
  }
  for (const std::string& name : options.excluded) {
    if (auto known = check(name, "--exclude " + name); !known) return known;
  }
  return {};
}

std::string Millimetres(double metres) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(1) << metres * 1e3 << " mm";
  return text.str();
}

void SumResiduals(Georeferencing& out) {
  double horizontal_m2 = 0, vertical_m2 = 0;
  for (const PointTest& test : out.snooping.tests) {
    horizontal_m2 += test.residual_m.head<2>().squaredNorm();
    vertical_m2 += test.residual_m.z() * test.residual_m.z();
    out.largest_m = std::max(out.largest_m, test.residual_m.norm());
  }
  const auto count = static_cast<double>(out.used);
  out.rms_horizontal_m = std::sqrt(horizontal_m2 / count);
  out.rms_vertical_m = std::sqrt(vertical_m2 / count);
  out.rms_m = std::sqrt((horizontal_m2 + vertical_m2) / count);
}

}  // namespace

base::Result<std::vector<MatchedPoint>> MatchPoints(const ControlFile& control,
                                                    const std::vector<TrackRow>& track,
                                                    const MatchOptions& options) {
  if (auto known = CheckNames(control, options); !known) return known.error();
  std::vector<MatchedPoint> matches;
  for (const ControlPoint& point : control.points) {
    const auto name = RigPointOf(point.name, track, options);
    if (!name) return name.error();
    if (!name->has_value()) continue;
    auto matched = Match(control, point, track, **name);
    if (!matched) return matched.error();
    const double sigma_m = point.sigma_m.value_or(options.control_sigma_m);
    matched->common.control_covariance_m2 = sigma_m * sigma_m * Matrix3d::Identity();
    matched->used = !Holds(options.excluded, point.name);
    for (const MatchedPoint& other : matches) {
      if (other.rig_name == matched->rig_name)
        return RefuseAt(control.path, "points " + other.common.name + " and " + point.name + " are both " +
                                          matched->rig_name + "; one place has one point");
    }
    matches.push_back(std::move(*matched));
  }
  if (matches.empty()) {
    return RefuseAt(control.path, "names no target or LED of the track, which has " + TargetsOf(track) +
                                      "; name points TARGET or TARGET.1 to TARGET.4, or give --pair");
  }
  return matches;
}

georef::AbsoluteOrientation Georeferencing::Orientation(const std::string& calibration_id) const {
  georef::AbsoluteOrientation orientation;
  orientation.T_s_b.rotation = fit.R_s_b;
  orientation.T_s_b.translation_m = fit.Apply(Vector3d::Zero());
  orientation.grid_scale_factor = fit.grid_scale_factor;
  orientation.reference_b_m = fit.reference_b_m;
  orientation.covariance = SigmaFactor() * SigmaFactor() * fit.covariance.topLeftCorner<6, 6>();
  orientation.calibration_id = calibration_id;
  return orientation;
}

std::optional<std::string> Georeferencing::Refusal() const {
  const bool exceeds = rms_m > limits.rms_m || largest_m > limits.residual_m;
  if (!exceeds && !snooping.suspects_blunder) return std::nullopt;
  std::ostringstream text;
  text << "refused: rms " << Millimetres(rms_m) << " (" << Millimetres(limits.rms_m)
       << " allowed), largest residual " << Millimetres(largest_m) << " (" << Millimetres(limits.residual_m)
       << " allowed)";
  if (!snooping.worst) return text.str() + "; too few points to tell which one is wrong";
  const std::string& name = points[*snooping.worst].common.name;
  text << "; point " << name
       << (snooping.suspects_blunder ? " is suspected of a blunder" : " fits the others worst")
       << std::setprecision(4) << " (test " << snooping.tests[*snooping.worst].left_out_test << ", critical "
       << snooping.left_out_critical << "): measure it anew, or leave it out with --exclude " << name;
  return text.str();
}

base::Result<Georeferencing> Adjust(std::vector<MatchedPoint> points, const HelmertOptions& options,
                                    const GeorefLimits& limits) {
  Georeferencing out;
  out.options = options;
  out.limits = limits;
  const auto middle =
      std::stable_partition(points.begin(), points.end(), [](const MatchedPoint& p) { return p.used; });
  out.used = static_cast<std::size_t>(middle - points.begin());
  out.points = std::move(points);
  std::vector<CommonPoint> used;
  for (std::size_t i = 0; i < out.used; ++i) used.push_back(out.points[i].common);
  auto fit = FitHelmert(used, options);
  if (!fit) return fit.error();
  out.fit = *fit;
  out.snooping = Snoop(used, out.fit, options);
  HelmertOptions with_scale = options;
  with_scale.estimate_scale = true;
  if (const auto scaled = FitHelmert(used, with_scale)) {
    out.scale_ppm = (scaled->scale - 1) * 1e6;
    out.scale_sigma_ppm = std::sqrt(scaled->covariance(6, 6)) * 1e6;
  }
  SumResiduals(out);
  return out;
}

}  // namespace adit::host
