// Blobs taken for LEDs -> a solution, with every other blob that fits it.
#pragma once

#include "firmware/stereo/solution.h"

namespace adit::stereo {

/// Builds solutions of one pair. One thread; no allocation.
class BarBuilder {
 public:
  BarBuilder(const optics::Rig& rig, const LocatorOptions& options);

  /// Sets the blobs of the pair; they must outlive what is built.
  void Set(const detect::BlobSet& left, const detect::BlobSet& right);

  /// The blobs of an image: 0 left, 1 right.
  const detect::BlobSet& Blobs(std::size_t side) const { return *blobs_[side]; }

  /// The bar through these blobs. Declines as Solver::Solve does; `reason` says why.
  std::optional<Solution> Build(const base::Target& target, const BarBlobs& blobs, LossReason& reason) const;

  /// Adds to a solution, image by image, the blobs that stand where its hidden LEDs must be: the nearest
  /// within the gate of the fit's covariance, if the fit bears it and it is as bright as `known`. What stands
  /// there and disagrees is something else, and the LED counts as hidden. An LED of `solution` is seen in
  /// both images or in none.
  Solution Completed(const base::Target& target, const Solution& solution, const LedFlux& known) const;

 private:
  /// The solution with the blob of one LED more in one image, if there is one.
  std::optional<Solution> With(const base::Target& target, const Solution& solution, std::size_t led,
                               std::size_t side, const LedFlux& known) const;
  /// The blob nearest to where LED `led` must be in an image, or kNoBlob.
  std::uint16_t NearestTo(const base::Target& target, const Solution& solution, std::size_t led,
                          std::size_t side) const;

  Views views_;
  Solver solver_;
  LocatorOptions options_;
  std::array<const detect::BlobSet*, 2> blobs_{};
};

}  // namespace adit::stereo
