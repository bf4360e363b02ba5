// Line targets of one length that cannot be taken for each other.
#pragma once

#include <string>
#include <vector>

#include "firmware/base/result.h"
#include "host/confusion.h"

namespace adit::host {

struct DesignOrder {
  double length_m = 1;
  double gap_min_m = 0.1;                 ///< smallest distance of two LEDs that the maker wants
  double distance_m = 110;                ///< as far as the bars must be told apart
  int count = 0;                          ///< bars wanted; 0: as many as fit
  double spot_sigma_px = 1.5;             ///< of an LED's image; closer than 4.75 of it two spots are one
  ViewConditions view{0.35, 3378, 0.05};  ///< bars that lean up to 20 degrees
};

struct TargetDesign {
  std::vector<base::Target> targets;  ///< bar_01 .., epicenter in the middle
  double gap_m = 0;                   ///< smallest gap: the maker's, or what does not merge
  double gap_px = 0;                  ///< its image, at `distance_m`, leaning as far as allowed
  double step_m = 0;                  ///< LEDs stand on multiples of it
  std::size_t layouts = 0;            ///< that were compared
  std::size_t fitting = 0;  ///< bars that can be told apart at NeededSigmas: how many identities fit
  double needed_sigmas = 0;
  double separation_sigmas = 0;  ///< of the two of `targets` that are nearest, and of the directions
};

/// Compares all layouts on whole centimetres (coarser multiples when there are more than 320), leaves out
/// those whose direction is not sure, and picks greedily, each bar the farthest from all before; from several
/// starts, the best kept; then single bars are exchanged while that helps. Declines (kFailed) an order in
/// which no layout fits, or more bars than fit, with what would help.
base::Result<TargetDesign> DesignTargets(const DesignOrder& order);

/// For people: what fits, and the LED places in metres.
std::string FormatDesign(const TargetDesign& design, const DesignOrder& order);

}  // namespace adit::host
