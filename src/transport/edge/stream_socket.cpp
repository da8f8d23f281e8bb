// SPDX-License-Identifier: LGPL-2.1-or-later
#include "transport/edge/stream_socket.hpp"

#include <arpa/inet.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstring>
#include <memory>
#include <random>

namespace weir::edge {
namespace {

constexpr int kBacklog = 128;

struct FreeAddresses {
  void operator()(addrinfo* list) const { freeaddrinfo(list); }
};
using Addresses = std::unique_ptr<addrinfo, FreeAddresses>;

// The IPv4 addresses of a name; `reason` if there is none.
Addresses find_addresses(const std::string& host, uint32_t port, bool listens,
                         std::string* reason) {
  addrinfo hints{};
  hints.ai_family = AF_INET;
  hints.ai_socktype = SOCK_STREAM;
  hints.ai_flags = AI_NUMERICSERV | (listens ? AI_PASSIVE : 0);
  addrinfo* found = nullptr;
  const int failed = getaddrinfo(host.empty() ? nullptr : host.c_str(),
                                 std::to_string(port).c_str(), &hints, &found);
  if (failed) *reason = gai_strerror(failed);
  return Addresses(failed ? nullptr : found);
}

Descriptor make_socket() {
  Descriptor out(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  return out;
}

void set_option(int socket, int level, int option, int value) noexcept {
  setsockopt(socket, level, option, &value, sizeof value);
}

// Small messages are sent at once, and the kernel finds out within two minutes that the machine of
// the other end has gone.
void set_options(int socket) noexcept {
  set_option(socket, IPPROTO_TCP, TCP_NODELAY, 1);
  set_option(socket, SOL_SOCKET, SO_KEEPALIVE, 1);
  set_option(socket, IPPROTO_TCP, TCP_KEEPIDLE, 60);
  set_option(socket, IPPROTO_TCP, TCP_KEEPINTVL, 10);
  set_option(socket, IPPROTO_TCP, TCP_KEEPCNT, 6);
}

std::string address_text(const std::string& host, uint32_t port) {
  return host + ":" + std::to_string(port);
}

// Waits until the connection is there; "" or why it is not.
std::string wait_connected(int socket, const io::Deadline& deadline, int cancel, bool* cancelled) {
  for (;;) {
    pollfd watched[] = {{socket, POLLOUT, 0}, {cancel, POLLIN, 0}};
    const int ready = poll(watched, 2, io::poll_timeout(deadline));
    if (ready < 0 && errno != EINTR) return std::strerror(errno);
    *cancelled = ready > 0 && watched[1].revents != 0;
    if (*cancelled) return "cancelled";
    if (ready == 0 && io::is_over(deadline)) return "no answer in time";
    if (ready <= 0) continue;
    return connection_error(socket);
  }
}

}  // namespace

Result<Descriptor> listen_on(const std::string& host, uint32_t port) {
  const auto failed = [&](const std::string& reason) {
    return Error{.code = Code::OPTION_VALUE,
                 .what = "the address to listen on cannot be used",
                 .offered = address_text(host, port) + ": " + reason,
                 .needed = "an IPv4 address or name of this machine, and a port that is free",
                 .fix = "host=localhost port=0, which uses a free port"};
  };
  std::string reason;
  const auto addresses = find_addresses(host, port, true, &reason);
  if (!addresses) return failed(reason);
  Descriptor out = make_socket();
  const int yes = 1;  // a restarted publisher takes its port again at once
  if (!out || setsockopt(out.get(), SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes) != 0 ||
      bind(out.get(), addresses->ai_addr, addresses->ai_addrlen) != 0 ||
      listen(out.get(), kBacklog) != 0)
    return failed(std::strerror(errno));
  return out;
}

uint16_t get_port(int socket) noexcept {
  sockaddr_in address{};
  socklen_t size = sizeof address;
  if (getsockname(socket, reinterpret_cast<sockaddr*>(&address), &size) != 0) return 0;
  return ntohs(address.sin_port);
}

Descriptor accept_from(int listener) noexcept {
  Descriptor out(accept4(listener, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
  if (out) set_options(out.get());
  return out;
}

std::string get_peer(int socket) {
  sockaddr_in address{};
  socklen_t size = sizeof address;
  char text[INET_ADDRSTRLEN] = "?";
  if (getpeername(socket, reinterpret_cast<sockaddr*>(&address), &size) == 0)
    inet_ntop(AF_INET, &address.sin_addr, text, sizeof text);
  return text;
}

Result<Descriptor> connect_to(const std::string& host, uint32_t port, const io::Deadline& deadline,
                              int cancel) {
  std::string reason;
  const auto addresses = find_addresses(host, port, false, &reason);
  for (const addrinfo* at = addresses.get(); at; at = at->ai_next) {
    Descriptor out = make_socket();
    if (!out) break;
    set_options(out.get());
    bool cancelled = false;
    reason = "";
    if (connect(out.get(), at->ai_addr, at->ai_addrlen) != 0)
      reason = errno == EINPROGRESS ? wait_connected(out.get(), deadline, cancel, &cancelled)
                                    : std::strerror(errno);
    if (reason.empty()) return out;
    if (cancelled) return Error{.code = Code::CANCELLED, .what = "connecting was cancelled"};
  }
  return Error{.code = Code::SERVER_UNREACHABLE,
               .what = "the edgesink of this stream cannot be reached",
               .offered = address_text(host, port) + ": " + reason,
               .needed = "an edgesink that already listens at this address",
               .fix = "reconnect=true, which waits for the edgesink"};
}

int64_t new_client_id() {
  std::random_device device;
  return static_cast<int64_t>((uint64_t{device()} << 32 | device()) >> 2);
}

bool is_address(const std::string& host) {
  in_addr address{};
  return inet_pton(AF_INET, host.c_str(), &address) == 1;
}

Result<Descriptor> start_connection(const wire::HostAddress& address) {
  sockaddr_in target{};
  target.sin_family = AF_INET;
  target.sin_port = htons(address.port);
  Descriptor out = make_socket();
  if (out && inet_pton(AF_INET, address.host.c_str(), &target.sin_addr) == 1) {
    set_options(out.get());
    if (connect(out.get(), reinterpret_cast<const sockaddr*>(&target), sizeof target) == 0 ||
        errno == EINPROGRESS)
      return out;
  }
  return Error{.code = Code::SERVER_UNREACHABLE,
               .what = "the listener of a client cannot be reached",
               .offered = address.to_string() + ": " + std::strerror(errno)};
}

bool is_connected(int socket) noexcept {
  sockaddr_in address{};
  socklen_t size = sizeof address;
  return getpeername(socket, reinterpret_cast<sockaddr*>(&address), &size) == 0;
}

std::string connection_error(int socket) {
  int error = 0;
  socklen_t size = sizeof error;
  getsockopt(socket, SOL_SOCKET, SO_ERROR, &error, &size);
  return error ? std::strerror(error) : "";
}

}  // namespace weir::edge
