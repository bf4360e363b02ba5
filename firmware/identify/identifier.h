// BlobSet -> SightingSet: four blobs that are collinear and have a target's p2 invariant, with the bar's
// direction.
#pragma once

#include <memory>
#include <vector>

#include "firmware/detect/blob_set.h"
#include "firmware/identify/model.h"
#include "firmware/identify/quadruple.h"
#include "firmware/identify/sighting_set.h"

namespace adit::identify {

/// The identification of one camera (seed 4.3.4.2). No allocation after construction; one thread.
///
/// Every two blobs that may be the model's base (an adjacent pair of LEDs, as short as is sensible) name
/// where the other two must be; a grid of the blobs answers that. So the cost grows with the pairs that are
/// close together, not with all pairs or quadruples.
///
/// Brightness is not compared: LEDs of one bar differ by dirt and distance from the beam's axis more than
/// lamps differ from LEDs.
class Identifier {
 public:
  explicit Identifier(const std::vector<Model>& models, const IdentifierOptions& options = {});
  ~Identifier();
  Identifier(Identifier&&) noexcept;
  Identifier& operator=(Identifier&&) noexcept;

  /// Finds every sighting of every model: four blobs whose order, length, collinearity, p2 invariant and
  /// perspective fit it. A layout that reads nearly the same from both ends gives two sightings, one for each
  /// direction; the geometry of the pair decides. `blobs` must outlive `out`. Nothing is declined silently:
  /// what did not fit is counted, a search that reached its budget says so.
  void Identify(const detect::BlobSet& blobs, SightingSet& out);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace adit::identify
