// SPDX-License-Identifier: LGPL-2.1-or-later
#include "net/server/connection_acceptor.hpp"

#include <fcntl.h>
#include <linux/tcp.h>
#include <netdb.h>
#include <netinet/in.h>
#include <sys/eventfd.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <exception>
#include <system_error>
#include <utility>

#include "net/server/peer_name.hpp"
#include "net/server/server_security.hpp"

namespace weir::net {
namespace {

constexpr int kBacklog = 128, kMaxAccepted = 64;  // in one turn
constexpr int kPauseMs = 100;                     // until descriptors or memory may be there again
constexpr int kLookMs = 250;                      // at what connections have received
constexpr int kPortTries = 16;                    // of free ports, until all addresses have one
constexpr char kUnixPeers[] = "unix:";
constexpr unsigned kUnansweredMs = 10'000;  // as set_keepalive()
constexpr uint32_t kOpenForEachBusy = 8, kCallsForEachStream = 2;
constexpr std::chrono::seconds kBarred{10};
constexpr std::chrono::milliseconds kLastHandover{500};

struct FreeAddresses {
  void operator()(addrinfo* list) const { freeaddrinfo(list); }
};
using Addresses = std::unique_ptr<addrinfo, FreeAddresses>;

Addresses find_addresses(const ListenOptions& options) {
  std::string host = options.host;
  if (host.starts_with('[') && host.ends_with(']')) host = host.substr(1, host.size() - 2);
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_NUMERICSERV | AI_PASSIVE;
  addrinfo* found = nullptr;
  const std::string port = std::to_string(options.port);
  return Addresses(getaddrinfo(host.c_str(), port.c_str(), &hints, &found) == 0 ? found : nullptr);
}

void set_option(int socket, int level, int option, unsigned value) noexcept {
  setsockopt(socket, level, option, &value, sizeof value);
}

// Small messages are sent at once, and the connection ends when what was sent is not acknowledged.
void set_connection_options(int socket) noexcept {
  set_option(socket, IPPROTO_TCP, TCP_NODELAY, 1);
  set_option(socket, IPPROTO_TCP, TCP_USER_TIMEOUT, kUnansweredMs);
}

void set_port(sockaddr* address, uint32_t port) {
  const auto number = htons(static_cast<uint16_t>(port));
  if (address->sa_family == AF_INET) reinterpret_cast<sockaddr_in*>(address)->sin_port = number;
  if (address->sa_family == AF_INET6) reinterpret_cast<sockaddr_in6*>(address)->sin6_port = number;
}

uint32_t bound_port(int socket) {
  sockaddr_storage address{};
  socklen_t size = sizeof address;
  getsockname(socket, reinterpret_cast<sockaddr*>(&address), &size);
  const void* const at = &address;
  if (address.ss_family == AF_INET) return ntohs(static_cast<const sockaddr_in*>(at)->sin_port);
  return ntohs(static_cast<const sockaddr_in6*>(at)->sin6_port);
}

// "::" listens on the addresses of both families. Without a descriptor, errno is the reason.
io::Descriptor listen_at(const sockaddr* address, socklen_t size) {
  io::Descriptor out(socket(address->sa_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!out) return out;
  set_option(out.get(), SOL_SOCKET, SO_REUSEADDR, 1);
  if (address->sa_family == AF_INET6) set_option(out.get(), IPPROTO_IPV6, IPV6_V6ONLY, 0);
  if (bind(out.get(), address, size) != 0 || listen(out.get(), kBacklog) != 0) return {};
  return out;
}

// One socket for each address of the name, all with one port. Addresses that this machine lacks
// are left out. Empty if a port is in use.
std::vector<io::Descriptor> listen_on_all(const addrinfo* first, uint32_t port) {
  std::vector<io::Descriptor> out;
  for (const addrinfo* at = first; at; at = at->ai_next) {
    const auto is_same = [at](const addrinfo& other) {
      return other.ai_addrlen == at->ai_addrlen &&
             std::memcmp(other.ai_addr, at->ai_addr, at->ai_addrlen) == 0;
    };
    const addrinfo* same = first;
    while (same != at && !is_same(*same)) same = same->ai_next;
    if (same != at) continue;
    sockaddr_storage address{};
    std::memcpy(&address, at->ai_addr, at->ai_addrlen);
    auto* const generic = reinterpret_cast<sockaddr*>(&address);
    set_port(generic, port);
    io::Descriptor socket = listen_at(generic, at->ai_addrlen);
    if (!socket && errno == EADDRINUSE) return {};
    if (!socket) continue;
    if (port == 0) port = bound_port(socket.get());
    out.push_back(std::move(socket));
  }
  return out;
}

bool is_unused_socket(const sockaddr_un& address) {
  struct stat found {};
  if (lstat(address.sun_path, &found) != 0 || !S_ISSOCK(found.st_mode)) return false;
  const io::Descriptor probe(socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  return probe &&
         connect(probe.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 &&
         errno == ECONNREFUSED;
}

Error unusable_address(const ListenOptions& options) {
  const bool is_tcp = options.unix_path.empty();
  return {.code = Code::OPTION_VALUE,
          .what = "the server cannot listen on this address",
          .offered = address_text(options),
          .needed = is_tcp ? "an address of this machine, and a port that no other program uses"
                           : "a path that no other server uses, in a folder that you can write to",
          .fix = is_tcp ? "port=0, which uses a free port" : ""};
}

uint32_t times(uint32_t count, uint32_t factor) {
  return static_cast<uint32_t>(std::min<uint64_t>(uint64_t{count} * factor, UINT32_MAX));
}

// A connection needs two descriptors, and the process needs some for other things.
uint32_t connections_by_descriptors() {
  constexpr rlim_t kPart = 4;
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return UINT32_MAX;
  return static_cast<uint32_t>(std::clamp<rlim_t>(limit.rlim_cur / kPart, 1, UINT32_MAX));
}

ConnectionLimits connection_limits(const ListenOptions& options) {
  ConnectionLimits out;
  out.connections = connections_by_descriptors();
  if (options.max_connections != 0)
    out.connections = std::min(out.connections, times(options.max_connections, kOpenForEachBusy));
  out.address_connections = times(options.max_address_connections, kOpenForEachBusy);
  out.calls = times(max_streams(options), kCallsForEachStream);
  out.message_bytes = options.max_bytes;
  out.bytes = options.max_address_bytes == 0
                  ? UINT64_MAX / 2
                  : std::max<uint64_t>(options.max_address_bytes, options.max_bytes);
  return out;
}

}  // namespace

// Above the limit of requests, so that calls beyond it are refused at once instead of waiting.
uint32_t max_streams(const ListenOptions& options) {
  return options.max_requests == 0 ? 0 : std::min(options.max_requests, 1u << 20) * 2 + 16;
}

Result<std::unique_ptr<ConnectionAcceptor>> ConnectionAcceptor::listen(
    const ListenOptions& options) {
  std::unique_ptr<ConnectionAcceptor> out(new ConnectionAcceptor(connection_limits(options)));
  const bool listens =
      options.unix_path.empty() ? out->bind_port(options) : out->bind_path(options);
  out->wake_ = io::Descriptor(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
  if (!listens || !out->wake_) return unusable_address(options);
  return out;
}

ConnectionAcceptor::~ConnectionAcceptor() {
  stop();
  struct stat now {};
  if (!path_.empty() && lstat(path_.c_str(), &now) == 0 && now.st_ino == inode_)
    unlink(path_.c_str());
}

bool ConnectionAcceptor::bind_port(const ListenOptions& options) {
  const auto addresses = find_addresses(options);
  const int tries = options.port == 0 ? kPortTries : 1;
  for (int i = 0; i < tries && listening_.empty(); ++i)
    listening_ = listen_on_all(addresses.get(), options.port);
  if (listening_.empty()) return false;
  port_ = bound_port(listening_.front().get());
  return true;
}

bool ConnectionAcceptor::bind_path(const ListenOptions& options) {
  sockaddr_un address{};
  if (options.unix_path.size() >= sizeof address.sun_path) return false;
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, options.unix_path.data(), options.unix_path.size());
  const auto* const generic = reinterpret_cast<const sockaddr*>(&address);
  if (is_unused_socket(address)) unlink(address.sun_path);
  io::Descriptor socket = listen_at(generic, sizeof address);
  struct stat made {};
  if (!socket || lstat(address.sun_path, &made) != 0) return false;
  path_ = options.unix_path;
  inode_ = made.st_ino;
  listening_.push_back(std::move(socket));
  return true;
}

void ConnectionAcceptor::start(Connected connected) {
  connected_ = std::move(connected);
  thread_ = std::thread([this] { serve(); });
}

void ConnectionAcceptor::stop() {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  const uint64_t one = 1;
  [[maybe_unused]] const ssize_t written = write(wake_.get(), &one, sizeof one);
  thread_.join();
  listening_.clear();
  std::unique_lock lock(mutex_);
  const auto is_done = [this] { return handing_over_ == 0; };
  if (handed_over_.wait_for(lock, kLastHandover, is_done)) return;
  for (auto& [name, connection] : connections_) refuse(&connection);
  handed_over_.wait(lock, is_done);
}

void ConnectionAcceptor::call_began(const std::string& peer) {
  const std::string name = plain_peer_name(peer);
  const std::lock_guard lock(mutex_);
  const auto [begin, end] = connections_.equal_range(name);
  for (auto at = begin; at != end; ++at) {
    Connection& connection = at->second;
    if (connection.network == kUnixPeers) return;
    connection.is_known = connection.had_message = true;
    ++connection.calls;
    if (limits_.calls != 0 && connection.calls > limits_.calls && !connection.is_refused)
      return bar(connection.network);
  }
}

void ConnectionAcceptor::message_came(const std::string& peer) {
  const std::string name = plain_peer_name(peer);
  const std::lock_guard lock(mutex_);
  const auto [begin, end] = connections_.equal_range(name);
  for (auto at = begin; at != end; ++at) at->second.had_message = true;
}

std::optional<uint64_t> ConnectionAcceptor::bytes_received(const std::string& peer) const {
  const std::string name = plain_peer_name(peer);
  const std::lock_guard lock(mutex_);
  std::optional<uint64_t> bytes;
  const auto [begin, end] = connections_.equal_range(name);
  for (auto at = begin; at != end; ++at)
    if (const auto traffic = read_traffic(at->second))
      bytes = bytes.value_or(0) + traffic->received;
  return bytes;
}

void ConnectionAcceptor::call_ended(const std::string& peer) {
  const std::string name = plain_peer_name(peer);
  const std::lock_guard lock(mutex_);
  const auto [begin, end] = connections_.equal_range(name);
  for (auto at = begin; at != end; ++at)
    if (at->second.calls > 0) --at->second.calls;
}

uint64_t ConnectionAcceptor::refused() const {
  const std::lock_guard lock(mutex_);
  return refused_;
}

std::optional<Traffic> ConnectionAcceptor::read_traffic(const Connection& connection) {
  tcp_info info{};
  socklen_t size = sizeof info;
  if (getsockopt(connection.socket.get(), IPPROTO_TCP, TCP_INFO, &info, &size) != 0)
    return std::nullopt;
  return Traffic{info.tcpi_bytes_received, info.tcpi_bytes_acked};
}

bool ConnectionAcceptor::is_costly(Connection* connection, Clock::time_point now) const {
  const Traffic traffic = read_traffic(*connection).value_or(Traffic{});
  if (std::exchange(connection->had_message, false)) {
    connection->cost.restart(traffic, now);
    connection->calls_then = connection->calls;
    return false;
  }
  const uint64_t messages = std::min(limits_.message_bytes * connection->calls_then, limits_.bytes);
  return connection->cost.is_too_high(traffic, messages, now);
}

// The thread forgets it when it sees the end.
void ConnectionAcceptor::refuse(Connection* connection) {
  if (std::exchange(connection->is_refused, true)) return;
  shutdown(connection->socket.get(), SHUT_RDWR);
  ++refused_;
}

// Bars a network after one of its connections cost too much, and ends its other connections that
// have as many calls as gRPC allows: they would follow.
void ConnectionAcceptor::bar(const std::string& network) {
  networks_[network].barred_until = Clock::now() + kBarred;
  for (auto& [name, connection] : connections_)
    if (connection.network == network &&
        connection.calls > std::max(limits_.calls / kCallsForEachStream, 1u))
      refuse(&connection);
}

// Goes on whatever happens: a server that accepts nothing would look like one that does.
void ConnectionAcceptor::serve() noexcept {
  for (;;) {
    try {
      if (!serve_once()) return;
    } catch (const std::exception&) {  // the thread entry: memory ran out
      pause();
    }
  }
}

bool ConnectionAcceptor::serve_once() {
  std::vector<pollfd> watched;
  int wait_ms = -1;
  {
    const std::lock_guard lock(mutex_);
    if (stopping_) return false;
    wait_ms = watch(&watched);
  }
  if (poll(watched.data(), watched.size(), wait_ms) < 0) {
    if (errno != EINTR) pause();
    return true;
  }
  {
    const std::lock_guard lock(mutex_);
    forget_ended(watched);
    refuse_silent_and_costly();
  }
  is_paused_ = false;
  for (size_t i = 0; i < listening_.size(); ++i)
    if (watched[1 + i].revents != 0) accept_from(listening_[i].get());
  return true;
}

void ConnectionAcceptor::pause() const noexcept {
  pollfd wake{wake_.get(), POLLIN, 0};
  poll(&wake, 1, kPauseMs);
}

// Returns for how many milliseconds nothing is to be done; -1 = until something happens.
int ConnectionAcceptor::watch(std::vector<pollfd>* watched) const {
  watched->reserve(1 + listening_.size() + connections_.size());
  watched->push_back({wake_.get(), POLLIN, 0});
  for (const auto& socket : listening_)
    watched->push_back({is_paused_ ? -1 : socket.get(), POLLIN, 0});
  for (const auto& [name, connection] : connections_)
    watched->push_back({connection.socket.get(), 0, 0});  // POLLHUP: its end
  if (is_paused_) return kPauseMs;
  return networks_.empty() ? -1 : kLookMs;
}

ConnectionAcceptor::Connections::iterator ConnectionAcceptor::forget(Connections::iterator at) {
  --networks_[at->second.network].connections;
  return connections_.erase(at);
}

void ConnectionAcceptor::forget_ended(const std::vector<pollfd>& watched) {
  std::vector<int> ended;
  for (size_t i = 1 + listening_.size(); i < watched.size(); ++i)
    if (watched[i].revents != 0) ended.push_back(watched[i].fd);
  if (ended.empty()) return;
  std::sort(ended.begin(), ended.end());
  for (auto at = connections_.begin(); at != connections_.end();)
    at = std::binary_search(ended.begin(), ended.end(), at->second.socket.get()) ? forget(at)
                                                                                 : std::next(at);
}

void ConnectionAcceptor::refuse_silent_and_costly() {
  const auto now = Clock::now();
  if (now < next_look_) return;
  next_look_ = now + std::chrono::milliseconds(kLookMs);
  for (auto& [name, connection] : connections_) {
    const bool is_silent = !connection.is_known && connection.accepted + limits_.first_call <= now;
    const bool costs = is_costly(&connection, now);
    if (costs) networks_[connection.network].barred_until = now + kBarred;
    if (is_silent || costs) refuse(&connection);
  }
  std::erase_if(networks_, [&](const auto& one) {
    return one.second.connections == 0 && one.second.barred_until <= now;
  });
}

void ConnectionAcceptor::accept_from(int listening) {
  for (int i = 0; i < kMaxAccepted && !is_paused_; ++i) {
    io::Descriptor socket(accept4(listening, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
    if (socket) {
      add(std::move(socket));
      continue;
    }
    // Without descriptors or memory the next one would fail too.
    is_paused_ = errno != EAGAIN && errno != EINTR && errno != ECONNABORTED;
    return;
  }
}

// The mutex is locked.
bool ConnectionAcceptor::make_room(const std::string& network) {
  const Network& known = networks_[network];
  const bool is_full = limits_.address_connections != 0 && network != kUnixPeers &&
                       known.connections >= limits_.address_connections;
  if (is_full || Clock::now() < known.barred_until) return false;
  if (connections_.size() < limits_.connections) return true;
  const auto is_before = [](const auto& a, const auto& b) {
    return std::pair(a.second.is_known, a.second.accepted) <
           std::pair(b.second.is_known, b.second.accepted);
  };
  const auto oldest = std::min_element(connections_.begin(), connections_.end(), is_before);
  if (oldest == connections_.end() || oldest->second.is_known) return false;
  refuse(&oldest->second);
  forget(oldest);
  return true;
}

void ConnectionAcceptor::add(io::Descriptor socket) {
  const int number = socket.get();
  set_connection_options(number);
  const std::string name = peer_name(number);
  const std::string network = peer_network(name);
  const std::lock_guard lock(mutex_);
  if (!make_room(network)) {
    ++refused_;
    return;
  }
  Connection connection;
  connection.socket = std::move(socket);
  connection.network = network;
  connection.accepted = Clock::now();
  connection.is_known = network == kUnixPeers;
  const auto added = connections_.emplace(name, std::move(connection));
  ++networks_[network].connections;
  if (hand_over(added->second)) return;
  forget(added);
  ++refused_;
  is_paused_ = true;
}

// False without a descriptor or a thread for it. The mutex is locked.
bool ConnectionAcceptor::hand_over(const Connection& connection) {
  io::Descriptor given(fcntl(connection.socket.get(), F_DUPFD_CLOEXEC, 0));
  if (!given) return false;
  try {
    std::thread([this, given = std::move(given)]() mutable {
      try {
        connected_(given.release());
      } catch (const std::exception&) {  // without memory: the acceptor ends the connection
      }
      const std::lock_guard lock(mutex_);
      if (--handing_over_ == 0) handed_over_.notify_all();
    }).detach();
  } catch (const std::system_error&) {
    return false;
  }
  ++handing_over_;
  return true;
}

}  // namespace weir::net
