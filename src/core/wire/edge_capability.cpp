// The texts of CAPABILITY and HOST_INFO messages (docs/compatibility/edge-wire.md 10.3).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/wire/edge_capability.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "core/text/text.hpp"
#include "core/wire/peer_error.hpp"

namespace weir::wire {
namespace {

constexpr std::string_view kSourceKey = "query_server_src_caps";
constexpr std::string_view kSinkKey = "query_server_sink_caps";
constexpr std::string_view kPublisherKey = "edge_sink_caps";
constexpr size_t kMaxHost = 253;  // of a DNS name

// The first value of `key` in @key@value@key@value. The odd pieces are keys.
std::optional<std::string_view> find_value(std::string_view text, std::string_view key) {
  const auto pieces = split(text, "@");
  for (size_t i = 1; i + 1 < pieces.size(); i += 2)
    if (pieces[i] == key) return pieces[i + 1];
  return std::nullopt;
}

Status check_caps(std::string_view caps) {
  if (caps.find_first_of(std::string_view("@\0", 2)) == std::string_view::npos) return ok();
  return Error{.code = Code::OPTION_VALUE,
               .what = "caps cannot be sent to a peer",
               .offered = quoted_text(caps),
               .needed = "caps without @ and NUL"};
}

bool is_host_character(char c) {
  const bool is_letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
  return is_letter || (c >= '0' && c <= '9') || c == '.' || c == '-' || c == '_';
}

bool is_own_machine(std::string_view host) {
  return equal_ignoring_case(host, "localhost") || host.starts_with("127.") || host == "0.0.0.0";
}

}  // namespace

Result<std::string_view> text_of_memory(std::span<const std::byte> memory) {
  const std::string_view bytes(reinterpret_cast<const char*>(memory.data()), memory.size());
  const size_t end = bytes.find('\0');
  if (end == std::string_view::npos)
    return peer_error("a text of a peer has no end", quoted_text(bytes),
                      "a NUL at the end of the text");
  return bytes.substr(0, end);
}

Result<std::string> query_capability_text(const QueryCapability& capability) {
  for (const auto* caps : {&capability.source_caps, &capability.sink_caps})
    if (auto status = check_caps(*caps); !status) return status.error();
  return "@" + std::string(kSourceKey) + "@" + capability.source_caps + "@" +
         std::string(kSinkKey) + "@" + capability.sink_caps;
}

Result<QueryCapability> parse_query_capability(std::string_view text) {
  const auto source = find_value(text, kSourceKey);
  const auto sink = find_value(text, kSinkKey);
  for (const auto& [caps, key] : {std::pair(source, kSourceKey), std::pair(sink, kSinkKey)})
    if (!caps || strip(*caps).empty())
      return peer_error("a query server does not announce its caps", quoted_text(text),
                        "@" + std::string(key) + "@ and the caps",
                        "connect again when the pipeline of the server plays, and check that its "
                        "tensor_query_serversrc and tensor_query_serversink have the same id");
  return QueryCapability{std::string(*source), std::string(*sink)};
}

Result<std::string> publisher_capability_text(std::string_view caps) {
  if (auto status = check_caps(caps); !status) return status.error();
  return "@" + std::string(kPublisherKey) + "@" + std::string(caps);
}

Result<std::string> parse_publisher_capability(std::string_view text) {
  const auto caps = find_value(text, kPublisherKey);
  if (!caps)
    return peer_error("a peer is not a publisher", quoted_text(text),
                      "@" + std::string(kPublisherKey) + "@ and the caps of the stream",
                      "check that an edgesink listens at this address");
  return std::string(*caps);
}

Result<HostAddress> parse_host_address(std::string_view text) {
  const size_t colon = text.find(':');
  if (colon == std::string_view::npos)
    return peer_error("the address of a peer has no port", quoted_text(text), "host:port");
  const auto host = text.substr(0, colon);
  const auto port = parse_unsigned(text.substr(colon + 1));
  if (!port || *port < 1 || *port > 65535)
    return peer_error("the address of a peer has no usable port", quoted_text(text),
                      "a port from 1 to 65535");
  if (host.empty() || host.size() > kMaxHost ||
      !std::all_of(host.begin(), host.end(), is_host_character))
    return peer_error("the address of a peer has no usable host", quoted_text(text),
                      "1 to 253 letters, digits, '.', '-' and '_'");
  return HostAddress{std::string(host), static_cast<uint16_t>(*port)};
}

Result<HostAddress> callback_address(const HostAddress& announced, std::string_view peer_address,
                                     std::span<const std::string> allowed) {
  if (is_own_machine(announced.host)) return HostAddress{std::string(peer_address), announced.port};
  const auto is_same = [&](std::string_view host) {
    return equal_ignoring_case(announced.host, host);
  };
  if (is_same(peer_address) || std::any_of(allowed.begin(), allowed.end(), is_same))
    return announced;
  return peer_error("a client requests its answers at another machine",
                    announced.to_string() + " from a connection of " + std::string(peer_address),
                    "the address of the connection",
                    "set host=" + std::string(peer_address) +
                        " on the client, or allow the other address with allow=" + announced.host);
}

}  // namespace weir::wire
