#include "drivers/modbus/connection.h"

#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <span>

#include "firmware/base/require.h"

namespace adit::modbus {

Connection::Connection(int socket, std::uint32_t peer, base::TimeNs now_ns)
    : socket_(socket), peer_(peer), active_ns_(now_ns) {}

Connection::~Connection() { ::close(socket_); }

ConnectionFate Connection::Serve(base::TimeNs now_ns, hal::RequestHandler& handler, std::uint64_t& requests) {
  // A client that floods is served in turns: a few rounds, then the others.
  constexpr int kRoundsMax = 8;
  for (int round = 0; round < kRoundsMax; ++round) {
    if (!Flush()) return ConnectionFate::kClosed;
    if (WantsToWrite()) return ConnectionFate::kStays;
    const ReadOutcome read = ReadSome();
    if (read == ReadOutcome::kEnd) return ConnectionFate::kClosed;
    // Whole requests may stay behind in the stream only if answers are held: then the socket is polled for
    // writing, and this is called again.
    AnswerWaiting(now_ns, handler, requests);
    if (stream_.Malformed()) return Flush() ? ConnectionFate::kMalformed : ConnectionFate::kClosed;
    if (held_ == 0 && read == ReadOutcome::kNothing) break;
  }
  if (!stream_.Partial()) {
    partial_since_ns_ = base::kNever;
  } else if (partial_since_ns_ == base::kNever) {
    partial_since_ns_ = now_ns;
  }
  return ConnectionFate::kStays;
}

bool Connection::Flush() {
  while (sent_ < held_) {
    // MSG_NOSIGNAL: a client that went away is an error code, not the end of the process.
    const ssize_t count =
        ::send(socket_, answers_.data() + sent_, held_ - sent_, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return errno == EAGAIN || errno == EWOULDBLOCK;
    sent_ += static_cast<std::size_t>(count);
  }
  sent_ = held_ = 0;
  return true;
}

Connection::ReadOutcome Connection::ReadSome() {
  const std::span<std::uint8_t> room = stream_.Room();
  // Reading into no room would look like the end of the stream. There always is some: each round answers and
  // drops at least one request before it reads again.
  ADIT_REQUIRE(!room.empty());
  const ssize_t count = ::recv(socket_, room.data(), room.size(), MSG_DONTWAIT);
  if (count == 0) return ReadOutcome::kEnd;
  if (count < 0) {
    const bool later = errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR;
    return later ? ReadOutcome::kNothing : ReadOutcome::kEnd;
  }
  stream_.Fill(static_cast<std::size_t>(count));
  return ReadOutcome::kBytes;
}

void Connection::AnswerWaiting(base::TimeNs now_ns, hal::RequestHandler& handler, std::uint64_t& requests) {
  const std::span<std::uint8_t> answers(answers_);
  for (auto frame = stream_.First(); frame && answers.size() - held_ >= kFrameMax; frame = stream_.First()) {
    const std::size_t length =
        handler.Answer(frame->message, answers.subspan(held_ + kMbapLength, kMessageMax));
    if (length > 0) {
      WriteMbap(answers.subspan(held_).first<kMbapLength>(), frame->transaction, length);
      held_ += kMbapLength + length;
    }
    stream_.Consume();
    ++requests;
    active_ns_ = now_ns;
    partial_since_ns_ = base::kNever;
  }
}

}  // namespace adit::modbus
