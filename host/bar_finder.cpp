#include "host/bar_finder.h"

#include <algorithm>

namespace adit::host {
namespace {

constexpr long kSightingsMax = 4;

BarView View(const identify::SightingSet& set, const identify::Sighting& sighting) {
  BarView view;
  for (std::size_t i = 0; i < view.size(); ++i) {
    const detect::Blob& blob = set.blob_set->blobs[sighting.blobs[i]];
    view[i] = {blob.raw_px, blob.ideal_px, blob.covariance_px2};
  }
  return view;
}

long CountOf(const identify::SightingSet& set, std::uint8_t target) {
  return std::count_if(set.sightings.begin(), set.sightings.end(),
                       [target](const identify::Sighting& s) { return s.target == target; });
}

identify::Identifier MakeIdentifier(const optics::CameraModel& camera,
                                    const std::vector<identify::Model>& models) {
  identify::IdentifierOptions options;
  options.focal_px = camera.fu_px;
  return identify::Identifier(models, options);
}

}  // namespace

BarFinder::BarFinder(const optics::CameraModel& left, const optics::CameraModel& right,
                     const std::vector<identify::Model>& models)
    : detectors_{detect::Detector(left, {}), detect::Detector(right, {})},
      identifiers_{MakeIdentifier(left, models), MakeIdentifier(right, models)},
      blobs_(std::make_unique<std::array<detect::BlobSet, 2>>()) {}

void BarFinder::Search(const base::CameraFrame& left, const base::CameraFrame& right) {
  detectors_[0].Detect(left, {}, (*blobs_)[0]);
  detectors_[1].Detect(right, {}, (*blobs_)[1]);
  Search((*blobs_)[0], (*blobs_)[1]);
}

void BarFinder::Search(const detect::BlobSet& left, const detect::BlobSet& right) {
  identifiers_[0].Identify(left, sightings_[0]);
  identifiers_[1].Identify(right, sightings_[1]);
}

void BarFinder::AppendBars(std::vector<StereoBar>& bars) const {
  const identify::SightingSet &left = sightings_[0], &right = sightings_[1];
  for (const identify::Sighting& l : left.sightings) {
    if (CountOf(left, l.target) > kSightingsMax || CountOf(right, l.target) > kSightingsMax) continue;
    for (const identify::Sighting& r : right.sightings) {
      if (r.target != l.target) continue;
      bars.push_back({left.blob_set->stamp.mid_exposure_ns, l.target, View(left, l), View(right, r)});
    }
  }
}

}  // namespace adit::host
