#include "firmware/pipeline/pipeline.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace adit::pipeline {
namespace {

identify::IdentifierOptions IdentifierOptionsOf(const optics::CameraModel& camera) {
  identify::IdentifierOptions options;
  options.focal_px = std::min(camera.fu_px, camera.fv_px);
  return options;
}

/// Whether two bars, one of them perhaps read backwards, have the same gaps within what the locator's
/// distance check allows: then every sighting of one is one of the other.
bool LookAlike(const base::Target& a, const base::Target& b) {
  const double within_m = stereo::LocatorOptions{}.scale * std::max(a.LengthM(), b.LengthM());
  bool forward = true, backward = true;
  for (std::size_t i = 0; i < a.leds_m.size(); ++i) {
    const double reversed_m = b.LengthM() - b.leds_m[b.leds_m.size() - 1 - i];
    forward = forward && std::abs(a.leds_m[i] - b.leds_m[i]) <= within_m;
    backward = backward && std::abs(a.leds_m[i] - reversed_m) <= within_m;
  }
  return forward || backward;
}

std::vector<std::string> NamesOf(const std::vector<identify::Model>& models,
                                 const std::vector<track::Body>& bodies) {
  std::vector<std::string> names;
  for (const identify::Model& model : models) names.push_back(model.target.name);
  for (const track::Body& body : bodies) names.push_back(body.name);
  return names;
}

}  // namespace

std::vector<base::Target> TargetsOf(const std::vector<identify::Model>& models) {
  std::vector<base::Target> targets;
  for (const identify::Model& model : models) targets.push_back(model.target);
  return targets;
}

base::Result<Pipeline> Pipeline::Make(const optics::Rig& rig, const std::vector<identify::Model>& models,
                                      const PipelineOptions& options) {
  const auto refusal = [](std::string detail) {
    return base::Error{base::ErrorCode::kOutOfRange, "models", std::move(detail)};
  };
  const std::size_t count = models.size() + options.tracker.bodies.size();
  if (models.empty() || count > identify::kMaxTargets) {
    return refusal("there are " + std::to_string(count) + " with the bodies; from 1 to " +
                   std::to_string(identify::kMaxTargets) + " are allowed");
  }
  for (std::size_t i = 0; i < models.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (models[i].target.name == models[j].target.name)
        return refusal("two are named " + models[i].target.name + "; names must differ");
      if (LookAlike(models[i].target, models[j].target))
        return refusal(models[j].target.name + " and " + models[i].target.name +
                       " have the same LED gaps within 0.5 % of the length; they could not be told apart");
    }
  }
  return Pipeline(rig, models, options);
}

Pipeline::Pipeline(const optics::Rig& rig, const std::vector<identify::Model>& models,
                   const PipelineOptions& options)
    : names_(NamesOf(models, options.tracker.bodies)),
      left_detector_(rig.left, options.detector),
      right_detector_(rig.right, options.detector),
      left_identifier_(models, IdentifierOptionsOf(rig.left)),
      locator_(rig, TargetsOf(models)),
      tracker_(TargetsOf(models), options.tracker),
      georeference_(options.georeference),
      windows_(options.windows),
      planner_(std::max(rig.left.fu_px, rig.left.fv_px)),
      plan_(std::make_unique<base::Latest<SearchPlan>>()) {}

void Pipeline::Detect(const base::CameraFrame& frame, detect::BlobSet& blobs) {
  auto& detector = frame.stamp.side == base::Side::kLeft ? left_detector_ : right_detector_;
  detector.Detect(frame, plan_->Load().WindowsIn(frame), blobs);
}

void Pipeline::Locate(const detect::BlobSet& left, const detect::BlobSet& right, PairResult& result) {
  left_identifier_.Identify(left, result.left);
  // Targets are sought in the left image only; the epipolar lines find them in the right one (seed 4.3.5).
  result.right.blob_set = &right;
  result.right.sightings.clear();
  tracker_.Expect(left.stamp.mid_exposure_ns, expectations_);
  locator_.Locate(result.left, result.right, expectations_, result.points);
  tracker_.Track(result.points, result.states);
  if (windows_) plan_->Store(planner_.Next(result.points, result.states));
  georeference_.Apply(result.states, result.fixes);
}

}  // namespace adit::pipeline
