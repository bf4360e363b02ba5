#include "host/progress.h"

#include <algorithm>
#include <iostream>

#include "drivers/linux/terminal.h"

namespace adit::host {

using Clock = std::chrono::steady_clock;

Progress::Progress(std::string label, std::size_t total)
    : label_(std::move(label)), total_(total), shown_(linux::IsTerminal(stderr)), next_(Clock::now()) {}

Progress::~Progress() {
  if (shown_) std::cerr << "\r\033[K" << std::flush;
}

void Progress::Step() {
  constexpr std::size_t kWidth = 30;
  ++done_;
  if (!shown_ || Clock::now() < next_) return;
  next_ = Clock::now() + std::chrono::milliseconds(100);
  const std::size_t filled = std::min(kWidth, kWidth * done_ / std::max<std::size_t>(1, total_));
  std::cerr << "\r" << label_ << " [" << std::string(filled, '#') << std::string(kWidth - filled, '.') << "] "
            << done_ << "/" << total_ << "\033[K" << std::flush;
}

}  // namespace adit::host
