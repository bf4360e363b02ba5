// Leica GSI-8 and GSI-16: lines of words, each of a word index, information, a sign and 8 or 16 digits.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/base/result.h"
#include "host/control_points.h"

namespace adit::host {

/// Reads every block that has a point number (word 11) and a coordinate (words 81 easting, 82 northing, 83
/// height); blocks without coordinates (observations, code blocks) are passed over. Leading zeros of a point
/// number are filled in by the instrument and not part of the name. Units 0 (mm), 6 (0.1 mm) and 8 (0.01 mm);
/// a value with `-` among its digits is no value.
///
/// A GSI-8 block has no room for national coordinates: the instrument cuts their leading digits off. Its
/// coordinates are taken only with `gsi8_offset_m`, which says what to add (zeros: nothing was cut off).
///
/// Declines (kMalformed) with file, line and word: a word of the wrong length or form, a unit that is not
/// metric, a coordinate that stands twice in a block, GSI-8 without an offset.
base::Result<std::vector<ControlPoint>> ParseGsi(std::string_view text, const std::string& path,
                                                 const std::optional<Eigen::Vector3d>& gsi8_offset_m);

}  // namespace adit::host
