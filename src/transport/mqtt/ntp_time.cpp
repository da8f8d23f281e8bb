// SPDX-License-Identifier: LGPL-2.1-or-later
#include "transport/mqtt/ntp_time.hpp"

#include <gio/gio.h>

#include <array>
#include <memory>
#include <optional>
#include <sstream>

namespace weir::transport {
namespace {

constexpr size_t kPacketBytes = 48;
constexpr uint8_t kClientVersion4 = 0x23, kServerMode = 4;
constexpr size_t kOriginate = 24, kReceive = 32, kTransmit = 40;
constexpr int64_t kEpoch1970 = 2208988800;  // seconds from 1900
constexpr uint16_t kPort = 123;
using Packet = std::array<uint8_t, kPacketBytes>;

struct UnreferenceAddress {
  void operator()(gpointer object) const { g_object_unref(object); }
};

int64_t read_time(const Packet& packet, size_t offset) {
  uint64_t value = 0;
  for (size_t i = 0; i < 8; ++i) value = value << 8 | packet[offset + i];
  const auto seconds = static_cast<int64_t>(value >> 32) - kEpoch1970;
  return seconds * 1'000'000'000 +
         static_cast<int64_t>(((value & 0xFFFFFFFF) * 1'000'000'000) >> 32);
}

std::optional<int64_t> ask(const std::string& server, unsigned timeout) {
  const std::unique_ptr<GSocketClient, UnreferenceAddress> client(g_socket_client_new());
  g_socket_client_set_enable_proxy(client.get(), FALSE);
  g_socket_client_set_socket_type(client.get(), G_SOCKET_TYPE_DATAGRAM);
  g_socket_client_set_protocol(client.get(), G_SOCKET_PROTOCOL_UDP);
  g_socket_client_set_timeout(client.get(), timeout);
  const std::unique_ptr<GSocketConnection, UnreferenceAddress> connection(
      g_socket_client_connect_to_host(client.get(), server.c_str(), kPort, nullptr, nullptr));
  if (!connection) return std::nullopt;
  GSocket* socket = g_socket_connection_get_socket(connection.get());
  Packet packet{kClientVersion4};
  const int64_t sent = unix_time();
  // A cookie: a response that does not repeat it is not to this request.
  for (size_t i = 0; i < 8; ++i) packet[kTransmit + i] = static_cast<uint8_t>(sent >> (8 * i));
  const Packet request = packet;
  if (g_socket_send(socket, reinterpret_cast<const char*>(packet.data()), kPacketBytes, nullptr,
                    nullptr) != static_cast<gssize>(kPacketBytes))
    return std::nullopt;
  if (g_socket_receive(socket, reinterpret_cast<char*>(packet.data()), kPacketBytes, nullptr,
                       nullptr) != static_cast<gssize>(kPacketBytes))
    return std::nullopt;
  const int64_t arrived = unix_time();
  const bool ours =
      std::equal(request.begin() + kTransmit, request.end(), packet.begin() + kOriginate);
  if (!ours || (packet[0] & 7) != kServerMode || packet[1] == 0) return std::nullopt;
  return ((read_time(packet, kReceive) - sent) + (read_time(packet, kTransmit) - arrived)) / 2;
}

}  // namespace

Result<int64_t> ntp_offset(const std::string& servers, std::chrono::seconds timeout) {
  std::istringstream list(servers);
  bool any = false;
  for (std::string server; std::getline(list, server, ',');) {
    if (server.empty()) continue;
    any = true;
    if (const auto offset = ask(server, static_cast<unsigned>(timeout.count()))) return *offset;
  }
  const Error error{.code = any ? Code::SERVER_UNREACHABLE : Code::OPTION_VALUE,
                    .what = "no NTP server answers",
                    .offered = "ntp-srvs=" + servers,
                    .needed = "a server that answers in time, as host:port,host:port",
                    .fix = "ntp-srvs=pool.ntp.org:123, or ntp-sync=false"};
  return error;
}

int64_t unix_time() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

}  // namespace weir::transport
