// Image pairs -> bars that both cameras identified, each image searched on its own (seed 4.3.3.2).
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "firmware/detect/detector.h"
#include "firmware/identify/identifier.h"
#include "firmware/optics/camera_model.h"
#include "host/stereo_bar.h"

namespace adit::host {

/// Detection and identification of both cameras, without any epipolar geometry: that is what is sought.
class BarFinder {
 public:
  BarFinder(const optics::CameraModel& left, const optics::CameraModel& right,
            const std::vector<identify::Model>& models);

  /// Searches both images. The records stay valid until the next call.
  void Search(const base::CameraFrame& left, const base::CameraFrame& right);
  /// Searches what a detection found, which must stay while the records are used.
  void Search(const detect::BlobSet& left, const detect::BlobSet& right);

  const identify::SightingSet& Sightings(base::Side side) const {
    return sightings_[static_cast<std::size_t>(side)];
  }

  /// Appends every combination of a left and a right sighting of one target. A target with more than four
  /// sightings in one image is left out there: it hides among lamps.
  void AppendBars(std::vector<StereoBar>& bars) const;

 private:
  std::array<detect::Detector, 2> detectors_;
  std::array<identify::Identifier, 2> identifiers_;
  std::unique_ptr<std::array<detect::BlobSet, 2>> blobs_;  // too large for a stack
  std::array<identify::SightingSet, 2> sightings_;
};

}  // namespace adit::host
