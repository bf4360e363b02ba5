#include "drivers/socketcan/candump_bus.h"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>

namespace adit::socketcan {
namespace {

// "(sec.usec) channel id#data\n": 13 + 16 (IFNAMSIZ) + 8 + 16 and the marks between them.
constexpr std::size_t kLineMax = 96;
constexpr std::size_t kChannelMax = 15;  // IFNAMSIZ - 1

// One line; returns its length.
std::size_t FormatLine(std::span<char, kLineMax> line, base::TimeNs now_ns, const std::string& channel,
                       const base::CanFrame& frame) {
  const long long seconds = now_ns / base::kNsPerS;
  const long long micros = now_ns % base::kNsPerS / base::kNsPerUs;
  const int digits = frame.extended ? 8 : 3;
  int length = std::snprintf(line.data(), line.size(), "(%010lld.%06lld) %s %0*X#", seconds, micros,
                             channel.c_str(), digits, static_cast<unsigned>(frame.id));
  for (std::size_t i = 0; i < frame.length && i < frame.data.size(); ++i) {
    const std::size_t at = static_cast<std::size_t>(length);
    length += std::snprintf(line.data() + at, line.size() - at, "%02X", static_cast<unsigned>(frame.data[i]));
  }
  line[static_cast<std::size_t>(length)] = '\n';
  return static_cast<std::size_t>(length) + 1;
}

}  // namespace

base::Result<std::unique_ptr<CandumpBus>> CandumpBus::Open(const std::string& path,
                                                           const std::string& channel,
                                                           const hal::Clock& clock) {
  if (channel.empty() || channel.size() > kChannelMax) {
    return base::Error{base::ErrorCode::kOutOfRange, path,
                       "channel name \"" + channel + "\" must have 1 to 15 characters"};
  }
  // O_APPEND: several boxes may share a file, and whoever truncates it meanwhile leaves no hole.
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (file < 0) {
    return base::Error{base::ErrorCode::kUnavailable, path,
                       std::string("cannot be opened for CAN frames: ") + std::strerror(errno)};
  }
  return std::unique_ptr<CandumpBus>(new CandumpBus(file, channel, clock));
}

CandumpBus::CandumpBus(int file, std::string channel, const hal::Clock& clock)
    : file_(file), channel_(std::move(channel)), clock_(clock) {}

CandumpBus::~CandumpBus() { ::close(file_); }

hal::SendOutcome CandumpBus::SendEpoch(std::span<const base::CanFrame> frames) {
  std::array<char, kLineMax * kMaxEpochFrames> text;
  if (frames.size() > kMaxEpochFrames) {
    ++health_.dropped_epochs;
    return hal::SendOutcome::kDropped;
  }
  const base::TimeNs now_ns = clock_.Now();
  std::size_t size = 0;
  for (const base::CanFrame& frame : frames) {
    size += FormatLine(std::span<char, kLineMax>(text.data() + size, kLineMax), now_ns, channel_, frame);
  }
  // One call for the epoch: a reader sees it whole. A short write (disk full) leaves a torn line, which
  // counts as an error; the next epoch is tried again.
  const ssize_t written = ::write(file_, text.data(), size);
  if (written != static_cast<ssize_t>(size)) {
    ++health_.errors;
    ++health_.dropped_epochs;
    return hal::SendOutcome::kDropped;
  }
  health_.sent_frames += frames.size();
  ++health_.confirmed_epochs;
  return hal::SendOutcome::kSent;
}

void CandumpBus::Poll(base::TimeNs) {}

}  // namespace adit::socketcan
