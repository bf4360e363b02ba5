// Whether a person watches.
#pragma once

#include <cstdio>

namespace adit::linux {

/// True if `stream` is a terminal, false if it is a pipe or a file.
bool IsTerminal(std::FILE* stream);

}  // namespace adit::linux
