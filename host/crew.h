// Independent pieces of work on all cores, their results in order.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "host/progress.h"

namespace adit::host {

/// Calls work(0) .. work(count - 1), several at once, and returns what they returned, by index: what a piece
/// gives depends on its index alone, so the whole does not depend on the number of threads. `work` must not
/// throw and must be safe to call at once.
template <class Result>
std::vector<Result> WorkInParallel(const std::string& label, std::size_t count,
                                   const std::function<Result(std::size_t)>& work,
                                   std::size_t threads = std::thread::hardware_concurrency()) {
  std::vector<Result> results(count);
  Progress progress(label, count);
  std::mutex progress_mutex;
  // Relaxed: each index is handed out once by the addition alone; the results are read after the joins.
  std::atomic<std::size_t> next{0};
  const auto run = [&] {
    for (;;) {
      const std::size_t i = next.fetch_add(1, std::memory_order_relaxed);
      if (i >= count) return;
      results[i] = work(i);
      const std::lock_guard lock(progress_mutex);
      progress.Step();
    }
  };
  std::vector<std::thread> crew;
  for (std::size_t i = 1; i < std::clamp<std::size_t>(threads, 1, std::max<std::size_t>(count, 1)); ++i)
    crew.emplace_back(run);
  run();
  for (std::thread& thread : crew) thread.join();
  return results;
}

}  // namespace adit::host
