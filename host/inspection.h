// Why a pair gave the positions that it gave: every bright thing, every candidate, and what became of it.
#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "firmware/optics/rig.h"
#include "firmware/pipeline/pipeline.h"
#include "host/pair_reader.h"

namespace adit::host {

/// A bright component that is no blob.
struct RejectedSpot {
  enum class Why : std::uint8_t { kSmall, kLarge, kNotRound, kBorder };
  Eigen::Vector2d raw_px;
  double half_px = 0;  ///< of the longer side of its box
  Why why = Why::kSmall;
};

/// Four blobs of the left image that passed the identification, and what the stereo stage made of them.
struct InspectedCandidate {
  identify::Sighting sighting;
  bool taken = false;  ///< it became the target's position
  std::string verdict;
};

/// One pair, looked into.
struct Inspection {
  std::unique_ptr<std::array<detect::BlobSet, 2>> blobs;
  std::unique_ptr<pipeline::PairResult> result;  ///< refers to the blobs
  std::array<std::vector<RejectedSpot>, 2> rejected;
  std::vector<InspectedCandidate> candidates;
};

/// The components of an image above `threshold_dn` (OpenCV's) that are no blobs of the set, by the
/// detection's own gates. Ones of a pixel or two are left out: noise.
std::vector<RejectedSpot> FindRejected(const base::ImageView& image, const detect::BlobSet& blobs,
                                       const detect::DetectorOptions& gates);

/// Feeds pairs to the pipeline of the box, the whole images searched, and looks into the last one.
class Inspector {
 public:
  Inspector(const optics::Rig& rig, const std::vector<identify::Model>& models, pipeline::Pipeline pipeline);

  /// The next pair, in time order. Valid until the next call.
  const Inspection& Look(const ImagePair& pair);

 private:
  InspectedCandidate Judge(const identify::Sighting& sighting);

  std::vector<base::Target> targets_;
  pipeline::Pipeline pipeline_;
  stereo::Locator locator_;  ///< judges one candidate at a time
  Inspection inspection_;
};

/// What a loss means, in a service engineer's words.
std::string Explain(stereo::LossReason reason);

}  // namespace adit::host
