// SightingSet x2 -> PointSet: epipolar correspondence, triangulation, refinement, validation, rigid bar fit.
#pragma once

#include <memory>
#include <vector>

#include "firmware/base/target.h"
#include "firmware/identify/sighting_set.h"
#include "firmware/optics/rig.h"
#include "firmware/stereo/point_set.h"

namespace adit::stereo {

/// Locates targets in the rig frame. No allocation after construction; one thread.
class Locator {
 public:
  Locator(const optics::Rig& rig, const std::vector<base::Target>& targets);
  ~Locator();
  Locator(Locator&&) noexcept;
  Locator& operator=(Locator&&) noexcept;

  /// Both sets must outlive `out`.
  void Locate(const identify::SightingSet& left, const identify::SightingSet& right, PointSet& out);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace adit::stereo
