// Control points: what the surveyors measured, as they hand it over.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/base/result.h"

namespace adit::host {

/// One coordinate as a file has it. A file may have none: that is no zero.
struct Coordinate {
  std::optional<double> value_m;
  std::string word;  ///< where it stands or is missing: a GSI word, or a column
};

/// One point of a survey file.
struct ControlPoint {
  std::string name;
  std::size_t line = 0;           ///< in the file, from 1
  std::array<Coordinate, 3> enh;  ///< easting, northing, height
  std::optional<double> sigma_m;  ///< one standard deviation of each coordinate, where the file says it
  bool has_offset = false;        ///< GSI-8, to which the offset was added
};

/// Control points with the file they come from.
struct ControlFile {
  std::string path;
  std::string crc32;  ///< of its bytes
  std::vector<ControlPoint> points;

  /// Easting, northing, height (metres) of the point. Declines (kMalformed), naming file, line and word, when
  /// one has no value.
  base::Result<Eigen::Vector3d> PositionOf(const ControlPoint& point) const;
  /// The point of that name, or null. Declines (kMalformed) when the file has two of it, naming both lines.
  base::Result<const ControlPoint*> Find(const std::string& name) const;
};

/// Reads CSV with a header line: the columns name, easting_m, northing_m, height_m and perhaps sigma_m, in
/// any order. An empty coordinate is no value. Declines (kMalformed) with file, line, column and value: an
/// unknown or missing column, a row with more or fewer fields, an empty name, what is no number, a coordinate
/// beyond 1e8 m, a sigma_m that is not above 0 and at most 1.
base::Result<std::vector<ControlPoint>> ParseControlCsv(std::string_view text, const std::string& path);

/// Reads a file: .csv, or .gsi (see gsi.h), by its ending. Declines when it has another ending, cannot be
/// read, is larger than 16 MiB, holds no point, or holds no GSI-8 for the offset that is given.
base::Result<ControlFile> LoadControlPoints(const std::string& path,
                                            const std::optional<Eigen::Vector3d>& gsi8_offset_m);

}  // namespace adit::host
