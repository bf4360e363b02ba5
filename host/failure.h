// How a command ends when it cannot do its work: one line and the exit code.
#pragma once

#include <iostream>

#include "firmware/base/result.h"

namespace adit::host {

/// Prints `adit <command>: <where>: <detail>` and returns the exit code: 2 wrong use or input, 1 failed work.
inline int Fail(const char* command, const base::Error& error) {
  std::cerr << "adit " << command << ": " << error.Line() << "\n";
  return error.ExitCode();
}

}  // namespace adit::host
