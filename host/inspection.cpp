#include "host/inspection.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace adit::host {
namespace {

using base::Side;
using Why = RejectedSpot::Why;

std::vector<base::Target> ModelTargets(const std::vector<identify::Model>& models) {
  std::vector<base::Target> targets;
  for (const identify::Model& model : models) targets.push_back(model.target);
  return targets;
}

bool IsBlob(const detect::BlobSet& set, const cv::Rect& box) {
  return std::any_of(set.blobs.begin(), set.blobs.end(), [&box](const detect::Blob& blob) {
    const double x = blob.raw_px.x(), y = blob.raw_px.y();
    return x >= box.x - 1 && y >= box.y - 1 && x <= box.x + box.width && y <= box.y + box.height;
  });
}

}  // namespace

std::vector<RejectedSpot> FindRejected(const base::ImageView& image, const detect::BlobSet& blobs,
                                       const detect::DetectorOptions& gates) {
  constexpr int kNoisePx = 2;
  const int depth = image.bits > 8 ? CV_16U : CV_8U;
  const cv::Mat pixels(image.height_px, image.width_px, depth, const_cast<std::uint8_t*>(image.data),
                       static_cast<std::size_t>(image.stride_bytes));
  const double per_dn = std::exp2(image.bits - 8);
  cv::Mat bright, labels, stats, middles;
  cv::compare(pixels, static_cast<double>(blobs.threshold_dn) * per_dn, bright, cv::CMP_GT);
  const int count = cv::connectedComponentsWithStats(bright, labels, stats, middles);
  std::vector<RejectedSpot> rejected;
  for (int i = 1; i < count; ++i) {
    const int* row = stats.ptr<int>(i);
    const cv::Rect box(row[cv::CC_STAT_LEFT], row[cv::CC_STAT_TOP], row[cv::CC_STAT_WIDTH],
                       row[cv::CC_STAT_HEIGHT]);
    const int area = row[cv::CC_STAT_AREA];
    if (area <= kNoisePx || IsBlob(blobs, box)) continue;
    const bool at_border = box.x == 0 || box.y == 0 || box.x + box.width == image.width_px ||
                           box.y + box.height == image.height_px;
    const Why why = area < gates.area_min_px   ? Why::kSmall
                    : area > gates.area_max_px ? Why::kLarge
                    : at_border                ? Why::kBorder
                                               : Why::kNotRound;
    rejected.push_back(
        {{middles.at<double>(i, 0), middles.at<double>(i, 1)}, 0.5 * std::max(box.width, box.height), why});
  }
  return rejected;
}

Inspector::Inspector(const optics::Rig& rig, const std::vector<identify::Model>& models,
                     pipeline::Pipeline pipeline)
    : targets_(ModelTargets(models)), pipeline_(std::move(pipeline)), locator_(rig, targets_) {
  inspection_.blobs = std::make_unique<std::array<detect::BlobSet, 2>>();
  inspection_.result = std::make_unique<pipeline::PairResult>();
}

InspectedCandidate Inspector::Judge(const identify::Sighting& sighting) {
  InspectedCandidate candidate;
  candidate.sighting = sighting;
  const stereo::TargetPoints& located = inspection_.result->points.targets[sighting.target];
  candidate.taken = located.status != stereo::FixStatus::kLost && located.blobs[0] == sighting.blobs;
  // Alone it either passes, and another or a doubt stood against it, or it fails by itself.
  identify::SightingSet alone;
  alone.blob_set = inspection_.result->left.blob_set;
  alone.sightings.push_back(sighting);
  const auto points = std::make_unique<stereo::PointSet>();
  locator_.Locate(alone, inspection_.result->right, *points);
  const stereo::TargetPoints& itself = points->targets[sighting.target];
  if (candidate.taken)
    candidate.verdict = "taken";
  else if (itself.status == stereo::FixStatus::kLost)
    candidate.verdict = "rejected: " + Explain(itself.reason);
  else
    candidate.verdict =
        "rejected: passes by itself; another candidate, or the place expected, stands against it";
  return candidate;
}

const Inspection& Inspector::Look(const ImagePair& pair) {
  for (const Side side : {Side::kLeft, Side::kRight}) {
    const auto i = static_cast<std::size_t>(side);
    const base::CameraFrame frame = pair.Frame(side);
    detect::BlobSet& blobs = (*inspection_.blobs)[i];
    pipeline_.Detect(frame, blobs);
    inspection_.rejected[i] = FindRejected(frame.image, blobs, detect::DetectorOptions{});
  }
  pipeline_.Locate((*inspection_.blobs)[0], (*inspection_.blobs)[1], *inspection_.result);
  inspection_.candidates.clear();
  for (const identify::Sighting& sighting : inspection_.result->left.sightings)
    inspection_.candidates.push_back(Judge(sighting));
  return inspection_;
}

std::string Explain(stereo::LossReason reason) {
  switch (reason) {
    case stereo::LossReason::kNone:
      return "nothing against it";
    case stereo::LossReason::kNoFrame:
      return "a camera delivered no usable image";
    case stereo::LossReason::kNotSeen:
      return "no four blobs in the left image have its spacing, nor three in both";
    case stereo::LossReason::kNoCorrespondence:
      return "an LED has no blob on its epipolar line in the right image";
    case stereo::LossReason::kDistances:
      return "the distances in space are not the target's";
    case stereo::LossReason::kAmbiguous:
      return "several places pass equally well";
    case stereo::LossReason::kGeometry:
      return "the rays do not meet in front of both cameras";
    case stereo::LossReason::kOneBar:
      return "one bar of the body is seen: its roll is open";
    case stereo::LossReason::kJump:
      return "it is not where the track allows, and was not yet seen there twice";
  }
  return "?";
}

}  // namespace adit::host
