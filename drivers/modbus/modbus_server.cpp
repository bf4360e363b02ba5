#include "drivers/modbus/modbus_server.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <thread>

#include "drivers/modbus/connection.h"

namespace adit::modbus {

/// A socket that listens, and where.
struct Listener {
  int socket;
  std::uint16_t port;
};

namespace {

// Limits are durations, so they are measured on a clock that nobody sets.
base::TimeNs SteadyNow() {
  return std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// Timeouts are looked at this often; they are seconds.
constexpr int kPollMs = 100;

base::Error Decline(const ServerOptions& options, base::ErrorCode code, const std::string& detail) {
  return {code, "modbus " + options.bind + ":" + std::to_string(options.port), detail};
}

void SetFlag(int socket, int level, int option) {
  const int on = 1;
  // A socket that refuses these still serves, only slower.
  (void)::setsockopt(socket, level, option, &on, sizeof on);
}

base::Result<Listener> Listen(const ServerOptions& options) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(options.port);
  if (::inet_pton(AF_INET, options.bind.c_str(), &address.sin_addr) != 1) {
    return Decline(options, base::ErrorCode::kOutOfRange, "is not an IPv4 address to listen on");
  }
  const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (socket < 0) return Decline(options, base::ErrorCode::kUnavailable, std::strerror(errno));
  // A restart must not wait for the sockets of the last run to die (TIME_WAIT).
  SetFlag(socket, SOL_SOCKET, SO_REUSEADDR);
  constexpr int kBacklog = 64;
  auto* raw = reinterpret_cast<sockaddr*>(&address);
  socklen_t size = sizeof address;
  if (::bind(socket, raw, size) != 0 || ::listen(socket, kBacklog) != 0 ||
      ::getsockname(socket, raw, &size) != 0) {
    const std::string reason = std::strerror(errno);
    ::close(socket);
    return Decline(options, base::ErrorCode::kUnavailable, "cannot listen: " + reason);
  }
  return Listener{socket, ntohs(address.sin_port)};
}

base::Result<std::vector<std::uint32_t>> ParseAdmitted(const ServerOptions& options) {
  std::vector<std::uint32_t> admitted;
  for (const std::string& text : options.admitted) {
    in_addr address{};
    if (::inet_pton(AF_INET, text.c_str(), &address) != 1) {
      return Decline(options, base::ErrorCode::kOutOfRange,
                     "admitted \"" + text + "\" is not an IPv4 address");
    }
    admitted.push_back(address.s_addr);
  }
  return admitted;
}

}  // namespace

class ModbusServer::Loop {
 public:
  Loop(const ServerOptions& options, const Listener& listener, std::vector<std::uint32_t> admitted,
       hal::RequestHandler& handler)
      : options_(options), listener_(listener), admitted_(std::move(admitted)), handler_(handler) {}
  ~Loop();
  Loop(const Loop&) = delete;
  Loop& operator=(const Loop&) = delete;

  bool Start();
  std::uint16_t Port() const { return listener_.port; }
  ServerHealth Health() const;

 private:
  using Connections = std::vector<std::unique_ptr<Connection>>;

  void Run();
  void PollOnce(std::vector<pollfd>& polled);
  void Accept(base::TimeNs now_ns);
  bool MakeRoom(std::uint32_t peer);
  bool IsAdmitted(std::uint32_t peer) const;
  bool ServeOne(Connection& connection, short events, base::TimeNs now_ns);

  ServerOptions options_;
  Listener listener_;
  std::vector<std::uint32_t> admitted_;
  hal::RequestHandler& handler_;
  Connections connections_;
  int wake_ = -1;
  // relaxed throughout: figures for people; none of them guards anything.
  std::atomic<std::uint64_t> requests_{0}, accepted_{0}, refused_{0}, malformed_{0}, timed_out_{0};
  std::atomic<std::uint32_t> clients_{0};
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

ModbusServer::Loop::~Loop() {
  // relaxed: the write to the eventfd below orders it before the wake-up.
  stop_.store(true, std::memory_order_relaxed);
  if (thread_.joinable()) {
    const std::uint64_t one = 1;
    (void)!::write(wake_, &one, sizeof one);
    thread_.join();
  }
  if (wake_ >= 0) ::close(wake_);
  ::close(listener_.socket);
}

bool ModbusServer::Loop::Start() {
  wake_ = ::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
  if (wake_ < 0) return false;
  connections_.reserve(options_.connections_max);
  thread_ = std::thread([this] { Run(); });
  return true;
}

void ModbusServer::Loop::Run() {
  std::vector<pollfd> polled;
  polled.reserve(options_.connections_max + 2);
  // relaxed: see the destructor.
  while (!stop_.load(std::memory_order_relaxed)) PollOnce(polled);
  connections_.clear();
}

void ModbusServer::Loop::PollOnce(std::vector<pollfd>& polled) {
  polled.clear();
  polled.push_back({wake_, POLLIN, 0});
  polled.push_back({listener_.socket, POLLIN, 0});
  for (const auto& connection : connections_) {
    polled.push_back(
        {connection->Socket(), static_cast<short>(connection->WantsToWrite() ? POLLOUT : POLLIN), 0});
  }
  if (::poll(polled.data(), polled.size(), kPollMs) < 0) return;
  const base::TimeNs now_ns = SteadyNow();
  for (std::size_t i = 0; i < connections_.size(); ++i) {
    if (!ServeOne(*connections_[i], polled[i + 2].revents, now_ns)) connections_[i].reset();
  }
  std::erase(connections_, nullptr);
  if (polled[1].revents != 0) Accept(now_ns);
  clients_.store(static_cast<std::uint32_t>(connections_.size()), std::memory_order_relaxed);
}

// False once the connection must be closed.
bool ModbusServer::Loop::ServeOne(Connection& connection, short events, base::TimeNs now_ns) {
  if (events != 0) {
    std::uint64_t requests = 0;
    const ConnectionFate fate = connection.Serve(now_ns, handler_, requests);
    requests_.fetch_add(requests, std::memory_order_relaxed);
    if (fate == ConnectionFate::kMalformed) malformed_.fetch_add(1, std::memory_order_relaxed);
    if (fate != ConnectionFate::kStays) return false;
  }
  const base::TimeNs partial_ns = connection.PartialSinceNs();
  const bool dripping = partial_ns != base::kNever && now_ns - partial_ns > options_.partial_limit_ns;
  const bool idle = now_ns - connection.ActiveNs() > options_.idle_limit_ns;
  if (dripping || idle) timed_out_.fetch_add(1, std::memory_order_relaxed);
  return !dripping && !idle;
}

void ModbusServer::Loop::Accept(base::TimeNs now_ns) {
  for (;;) {
    sockaddr_in peer{};
    socklen_t size = sizeof peer;
    const int socket =
        ::accept4(listener_.socket, reinterpret_cast<sockaddr*>(&peer), &size, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (socket < 0) return;
    if (!MakeRoom(peer.sin_addr.s_addr)) {
      refused_.fetch_add(1, std::memory_order_relaxed);
      ::close(socket);
      continue;
    }
    // An answer is one small segment that nothing follows: waiting to fill it up costs 40 ms.
    SetFlag(socket, IPPROTO_TCP, TCP_NODELAY);
    accepted_.fetch_add(1, std::memory_order_relaxed);
    connections_.push_back(std::make_unique<Connection>(socket, peer.sin_addr.s_addr, now_ns));
  }
}

bool ModbusServer::Loop::IsAdmitted(std::uint32_t peer) const {
  return std::ranges::find(admitted_, peer) != admitted_.end();
}

// Whether one more connection of `peer` may come in; closes the longest idle stranger for a listed peer.
bool ModbusServer::Loop::MakeRoom(std::uint32_t peer) {
  const bool listed = IsAdmitted(peer);
  const auto same = std::ranges::count_if(connections_, [&](const auto& c) { return c->Peer() == peer; });
  if (!listed && static_cast<std::size_t>(same) >= options_.connections_per_peer) return false;
  if (connections_.size() < options_.connections_max) return true;
  if (!listed) return false;
  auto oldest = connections_.end();
  for (auto it = connections_.begin(); it != connections_.end(); ++it) {
    const bool stranger = !IsAdmitted((*it)->Peer());
    if (stranger && (oldest == connections_.end() || (*it)->ActiveNs() < (*oldest)->ActiveNs())) oldest = it;
  }
  if (oldest == connections_.end()) return false;
  connections_.erase(oldest);
  return true;
}

ServerHealth ModbusServer::Loop::Health() const {
  return {requests_.load(std::memory_order_relaxed),  accepted_.load(std::memory_order_relaxed),
          refused_.load(std::memory_order_relaxed),   malformed_.load(std::memory_order_relaxed),
          timed_out_.load(std::memory_order_relaxed), clients_.load(std::memory_order_relaxed)};
}

base::Result<std::unique_ptr<ModbusServer>> ModbusServer::Open(const ServerOptions& options,
                                                               hal::RequestHandler& handler) {
  auto admitted = ParseAdmitted(options);
  if (!admitted) return admitted.error();
  auto listener = Listen(options);
  if (!listener) return listener.error();
  auto loop = std::make_unique<Loop>(options, *listener, std::move(*admitted), handler);
  if (!loop->Start()) return Decline(options, base::ErrorCode::kUnavailable, std::strerror(errno));
  return std::unique_ptr<ModbusServer>(new ModbusServer(std::move(loop)));
}

ModbusServer::ModbusServer(std::unique_ptr<Loop> loop) : loop_(std::move(loop)) {}
ModbusServer::~ModbusServer() = default;
std::uint16_t ModbusServer::Port() const { return loop_->Port(); }
ServerHealth ModbusServer::Health() const { return loop_->Health(); }

}  // namespace adit::modbus
