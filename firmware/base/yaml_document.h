// From bytes to one YAML map, and YAML in the words of messages. For yaml.cpp; everyone else takes yaml.h.
#pragma once

#include <yaml-cpp/yaml.h>

#include <cstddef>
#include <string>

#include "firmware/base/result.h"

namespace adit::base {

inline constexpr std::size_t kLargestYamlBytes = 1 << 20;  // settings are some KB; more is the wrong file

/// The map that `text` is. Declines with kMalformed, naming `name` and if possible the line: not YAML, no map
/// of keys, more than one document, binary, or too large.
Result<YAML::Node> ParseYamlMap(const std::string& text, const std::string& name);

/// What a file says, fit for one line of a terminal: without control characters, not longer than it helps.
std::string Printable(const std::string& raw);

/// A value in words: "'text'", "a list of 3", "a map", "nothing".
std::string Show(const YAML::Node& node);

}  // namespace adit::base
