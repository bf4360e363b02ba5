// A table of comma separated values with a header line, as adit's tools exchange them.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/base/result.h"
#include "firmware/base/time.h"

namespace adit::host {

/// Columns are asked for by name, so that files may hold more of them, in any order. No quoting: the names in
/// adit's files hold no commas. Mistakes are one line: file, line, column, value, what is allowed.
class CsvTable {
 public:
  /// Reads a file. Declines a missing or empty one, a missing column of `required`, and lines whose number of
  /// cells differs from the header's.
  static base::Result<CsvTable> Open(const std::string& path, const std::vector<std::string>& required);

  std::size_t Rows() const { return rows_.size(); }
  /// The cell as written; empty for an empty cell. `column` must be one of `required`.
  std::string_view Text(std::size_t row, std::string_view column) const;
  /// A number; an empty cell has none. Declines anything else.
  base::Result<std::optional<double>> Number(std::size_t row, std::string_view column) const;
  /// A time, which a double cannot hold. Declines an empty cell too.
  base::Result<base::TimeNs> Time(std::size_t row, std::string_view column) const;
  /// "file:line: column"
  std::string Where(std::size_t row, std::string_view column) const;

 private:
  struct Row {
    std::size_t line;
    std::vector<std::string> cells;
  };
  std::string path_;
  std::vector<std::string> header_;
  std::vector<Row> rows_;
};

}  // namespace adit::host
