// Proposes quadruples of blobs that may be one model's LEDs.
#pragma once

#include "firmware/identify/quadruple.h"

namespace adit::identify {

/// Searches a grid of blobs for one model.
class QuadrupleSearch {
 public:
  QuadrupleSearch(const Model& model, const IdentifierOptions& options);

  /// Appends what passes to `out`, marked with `target`. `budget` counts down with every blob looked at; at 0
  /// the search ends and says so in `out`.
  void Run(const BlobGrid& grid, std::uint8_t target, long& budget, SightingSet& out) const;

 private:
  /// A line through the images of the base LEDs: LED `base_` at `origin`, the next LED `gap_px` along it.
  struct Base;

  void SeekFar(const Base& base, SightingSet& out) const;
  void SeekRest(const Base& base, std::size_t far, double far_px, SightingSet& out) const;
  double AlongPx(const Base& base, double ds_m, double gain_per_m) const;
  double Reach(const Base& base, std::size_t led) const;

  QuadrupleTest test_;
  std::size_t base_ = 0;  ///< LED index; the base is this LED and the next
  std::size_t far_ = 0;   ///< sought first: the one that fixes the perspective best
  std::size_t rest_ = 0;
  double gap_m_ = 0;
  double gap_min_px_ = 0, gap_max_px_ = 0;
};

}  // namespace adit::identify
