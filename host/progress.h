// A progress bar for long work: on a terminal only, quiet in a pipe.
#pragma once

#include <chrono>
#include <cstddef>
#include <string>

namespace adit::host {

/// Writes to stderr, at most ten times a second; erases itself when it goes out of scope, so that an error
/// line stands alone.
class Progress {
 public:
  Progress(std::string label, std::size_t total);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void Step();

 private:
  std::string label_;
  std::size_t total_, done_ = 0;
  bool shown_;
  std::chrono::steady_clock::time_point next_;
};

}  // namespace adit::host
