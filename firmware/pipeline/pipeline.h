// The product, top to bottom, without threads: two images in, positions out. The box's threads and `adit
// track` run this same code.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "firmware/base/latest.h"
#include "firmware/base/result.h"
#include "firmware/detect/detector.h"
#include "firmware/georef/geo_fix.h"
#include "firmware/georef/georeference.h"
#include "firmware/identify/identifier.h"
#include "firmware/pipeline/search_plan.h"
#include "firmware/stereo/locator.h"
#include "firmware/track/tracker.h"

namespace adit::pipeline {

struct PipelineOptions {
  detect::DetectorOptions detector;
  bool windows = true;  ///< search around the targets that are followed, and all over now and then
  track::TrackerOptions tracker = {};
  georef::Georeference georeference = {};  ///< by default none: the site frame is the rig frame
};

/// All records of one pair. Large (some 100 kB): make it once and reuse it.
struct PairResult {
  identify::SightingSet left, right;
  stereo::PointSet points;
  track::TargetStateSet states;
  georef::GeoFixSet fixes;
};

/// The targets of the models, in their order.
std::vector<base::Target> TargetsOf(const std::vector<identify::Model>& models);

/// The chain of the stages. Detect may run in one thread per side at once; Locate in one other thread.
class Pipeline {
 public:
  /// Refuses no models, too many (with the bodies), two of one name, or two whose LED gaps are the same
  /// within 0.5 %.
  static base::Result<Pipeline> Make(const optics::Rig& rig, const std::vector<identify::Model>& models,
                                     const PipelineOptions& options);

  /// Frame -> blobs, for the camera of the frame's side, in the windows that the last Locate left.
  void Detect(const base::CameraFrame& frame, detect::BlobSet& blobs);

  /// Blobs of one pair -> fixes. `left` and `right` must outlive `result`.
  void Locate(const detect::BlobSet& left, const detect::BlobSet& right, PairResult& result);

  /// Whom the fixes are of, in their order: the targets, then the bodies.
  const std::vector<std::string>& Names() const { return names_; }

 private:
  Pipeline(const optics::Rig& rig, const std::vector<identify::Model>& models,
           const PipelineOptions& options);

  std::vector<std::string> names_;
  detect::Detector left_detector_, right_detector_;
  identify::Identifier left_identifier_;
  stereo::Locator locator_;
  track::Tracker tracker_;
  stereo::ExpectationSet expectations_{};  ///< of the pair being located; here for its size
  georef::Georeference georeference_;
  bool windows_;
  SearchPlanner planner_;
  std::unique_ptr<base::Latest<SearchPlan>>
      plan_;  ///< written by Locate, read by both Detects; at a fixed address
};

}  // namespace adit::pipeline
