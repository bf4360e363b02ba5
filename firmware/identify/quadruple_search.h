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

  void SeekThird(const Base& base, SightingSet& out) const;
  void SeekFourth(const Base& base, std::size_t third, double third_px, SightingSet& out) const;
  /// Place `ds_m` from the base LED, in gaps, at a depth gain of `gain_per_m`.
  double AlongGaps(double ds_m, double gain_per_m) const {
    return (ds_m / gap_m_) * (1 + gain_per_m * gap_m_) / (1 + gain_per_m * ds_m);
  }

  QuadrupleTest test_;
  std::size_t base_ = 0;   ///< LED index; the base is this LED and the next
  std::size_t third_ = 0;  ///< sought next: the nearest to the base, in a strip as long as perspective allows
  std::size_t fourth_ = 0;  ///< sought last: where the other three say
  double gap_m_ = 0;
  double third_m_ = 0, fourth_m_ = 0;  ///< from the base LED, signed
  double gap_min_px_ = 0, gap_max_px_ = 0;
  /// Nearest and farthest place of the third LED and nearest of the fourth, in gaps from the base LED, within
  /// the perspective that is possible at all; signed.
  double third_from_ = 0, third_to_ = 0, fourth_nearest_ = 0;
  double third_reach_ = 0;   ///< tolerance of the third LED's place, per pixel of centroid noise
  double fourth_reach_ = 0;  ///< and of the fourth's
};

}  // namespace adit::identify
