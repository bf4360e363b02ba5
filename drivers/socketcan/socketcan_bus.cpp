#include "drivers/socketcan/socketcan_bus.h"

#include <linux/can.h>
#include <linux/can/error.h>

#include <algorithm>

namespace adit::socketcan {

base::Result<std::unique_ptr<SocketCanBus>> SocketCanBus::Open(const std::string& interface_name) {
  auto socket = OpenKernelCanSocket(interface_name);
  if (!socket) return socket.error();
  return std::make_unique<SocketCanBus>(std::move(*socket));
}

hal::SendOutcome SocketCanBus::SendEpoch(std::span<const base::CanFrame> frames) {
  if (down_ || frames.size() > kMaxEpochFrames) {
    ++health_.dropped_epochs;
    return down_ ? hal::SendOutcome::kDown : hal::SendOutcome::kDropped;
  }
  if (!in_flight_.empty()) {
    ++health_.dropped_epochs;
    return hal::SendOutcome::kBusy;
  }
  confirmed_ = 0;
  complete_ = true;
  sent_ns_ = now_ns_;
  for (const base::CanFrame& frame : frames) {
    const WriteOutcome outcome = socket_->Write(frame);
    if (outcome == WriteOutcome::kTaken) {
      in_flight_.push_back(frame);
      ++health_.sent_frames;
      continue;
    }
    // What was taken stays in flight: it must reach the bus, or be emptied out, before anything new goes.
    complete_ = false;
    ++health_.dropped_epochs;
    if (outcome == WriteOutcome::kFull) return hal::SendOutcome::kDropped;
    GoDown();
    return hal::SendOutcome::kDown;
  }
  return hal::SendOutcome::kSent;
}

void SocketCanBus::Poll(base::TimeNs now_ns) {
  now_ns_ = now_ns;
  // The first epoch may go out before the first Poll, and the box clock may be set back.
  if (sent_ns_ == base::kNever || sent_ns_ > now_ns) sent_ns_ = now_ns;
  if (down_ && restart_ns_ > now_ns + kBackOffMaxNs) restart_ns_ = now_ns;
  // Bounded, so that a flooded bus cannot keep the publisher here.
  constexpr int kReadsMax = 1000;
  for (int i = 0; i < kReadsMax; ++i) {
    const std::optional<ReceivedFrame> received = socket_->Read();
    if (!received) break;
    if (received->error) {
      TakeError(received->error_class);
    } else if (received->own) {
      TakeEcho(received->frame);
    }
  }
  if (down_) {
    if (now_ns >= restart_ns_) TryRestart();
    return;
  }
  if (!in_flight_.empty() && now_ns - sent_ns_ > kEchoLimitNs) {
    if (complete_) ++health_.dropped_epochs;
    health_.stalled = true;
    GoDown();
    // The first attempt at once: a stall costs one epoch if emptying the queue cures it.
    TryRestart();
  }
}

void SocketCanBus::TakeEcho(const base::CanFrame& frame) {
  // The kernel echoes in the order of sending. An echo that does not match is of an epoch given up before.
  if (confirmed_ >= in_flight_.size() || in_flight_[confirmed_] != frame) return;
  ++confirmed_;
  if (confirmed_ < in_flight_.size()) return;
  in_flight_.clear();
  if (!complete_) return;
  ++health_.confirmed_epochs;
  health_.stalled = false;
  back_off_ns_ = kBackOffMinNs;
}

void SocketCanBus::TakeError(std::uint32_t error_class) {
  if (error_class == CAN_ERR_RESTARTED) return;
  ++health_.errors;
  if ((error_class & CAN_ERR_BUSOFF) == 0 || down_) return;
  ++health_.bus_off;
  if (!in_flight_.empty() && complete_) ++health_.dropped_epochs;
  GoDown();
}

void SocketCanBus::GoDown() {
  down_ = true;
  restart_ns_ = now_ns_ + back_off_ns_;
}

void SocketCanBus::TryRestart() {
  restart_ns_ = now_ns_ + back_off_ns_;
  back_off_ns_ = std::min(2 * back_off_ns_, kBackOffMaxNs);
  if (!socket_->CycleInterface()) return;
  // The interface is empty now; echoes that were already waiting in the socket no longer match anything.
  in_flight_.clear();
  confirmed_ = 0;
  down_ = false;
}

}  // namespace adit::socketcan
