// SPDX-License-Identifier: LGPL-2.1-or-later
#include "net/server/peer_name.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <cstring>

namespace weir::net {
namespace {

constexpr char kUnix[] = "unix:";

bool is_unix(const std::string& peer) {
  return peer.starts_with(kUnix);
}

std::string name_text(const char* family, const std::string& host, const std::string& port) {
  return std::string(family) + ":" + host + ":" + port;
}

}  // namespace

std::string peer_host(const std::string& peer) {
  if (is_unix(peer)) return "";
  const size_t begin = peer.find(':') + 1, end = peer.rfind(':');
  std::string host = peer.substr(begin, end > begin ? end - begin : std::string::npos);
  if (host.starts_with("%5B")) host = host.substr(3, host.rfind("%5D") - 3);
  if (host.starts_with('[')) host = host.substr(1, host.rfind(']') - 1);
  return host.substr(0, host.find('%'));  // without the interface of a link-local address
}

std::string peer_network(const std::string& peer) {
  if (is_unix(peer)) return kUnix;
  std::string host = peer_host(peer);
  constexpr size_t kHostBytes = 8;
  in6_addr address{};
  char text[INET6_ADDRSTRLEN] = "";
  if (inet_pton(AF_INET6, host.c_str(), &address) != 1) return host;
  std::fill(std::end(address.s6_addr) - kHostBytes, std::end(address.s6_addr), uint8_t{0});
  inet_ntop(AF_INET6, &address, text, sizeof text);
  return std::string(text) + "/64";
}

std::string peer_name(int socket) {
  sockaddr_storage storage{};
  socklen_t size = sizeof storage;
  if (getpeername(socket, reinterpret_cast<sockaddr*>(&storage), &size) != 0) return kUnix;
  char text[INET6_ADDRSTRLEN] = "";
  if (storage.ss_family == AF_INET) {
    sockaddr_in address{};
    std::memcpy(&address, &storage, sizeof address);
    inet_ntop(AF_INET, &address.sin_addr, text, sizeof text);
    return name_text("ipv4", text, std::to_string(ntohs(address.sin_port)));
  }
  if (storage.ss_family != AF_INET6) return kUnix;
  sockaddr_in6 address{};
  std::memcpy(&address, &storage, sizeof address);
  const std::string port = std::to_string(ntohs(address.sin6_port));
  constexpr size_t kMappedAt = 12;
  if (IN6_IS_ADDR_V4MAPPED(&address.sin6_addr)) {
    inet_ntop(AF_INET, &address.sin6_addr.s6_addr[kMappedAt], text, sizeof text);
    return name_text("ipv4", text, port);
  }
  inet_ntop(AF_INET6, &address.sin6_addr, text, sizeof text);
  return name_text("ipv6", text, port);
}

std::string plain_peer_name(const std::string& peer) {
  if (is_unix(peer)) return kUnix;
  return peer.substr(0, peer.find(':') + 1) + peer_host(peer) + peer.substr(peer.rfind(':'));
}

}  // namespace weir::net
