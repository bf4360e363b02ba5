// A file or folder that a command line names twice.
#pragma once

#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <system_error>
#include <vector>

namespace adit::host {

/// The first of `paths` that leads to the same place as one before it.
inline std::optional<std::string> RepeatedPath(const std::vector<std::string>& paths) {
  std::set<std::filesystem::path> seen;
  for (const std::string& path : paths) {
    std::error_code unused;
    std::filesystem::path place = std::filesystem::weakly_canonical(path, unused);
    if (!place.has_filename()) place = place.parent_path();
    if (!seen.insert(place).second) return path;
  }
  return std::nullopt;
}

}  // namespace adit::host
