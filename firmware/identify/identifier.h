// BlobSet -> SightingSet: four blobs that are collinear and have a target's p2 invariant, with the bar's
// direction.
#pragma once

#include <memory>
#include <vector>

#include "firmware/detect/blob_set.h"
#include "firmware/identify/model.h"
#include "firmware/identify/sighting_set.h"

namespace adit::identify {

/// The identification of one camera. No allocation after construction; one thread.
class Identifier {
 public:
  explicit Identifier(const std::vector<Model>& models);
  ~Identifier();
  Identifier(Identifier&&) noexcept;
  Identifier& operator=(Identifier&&) noexcept;

  /// Finds every sighting of every model. `blobs` must outlive `out`.
  void Identify(const detect::BlobSet& blobs, SightingSet& out);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace adit::identify
