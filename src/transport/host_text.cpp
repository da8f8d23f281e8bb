// SPDX-License-Identifier: LGPL-2.1-or-later
#include "transport/host_text.hpp"

#include <algorithm>
#include <limits>

#include "core/text/text.hpp"

namespace weir::transport {
namespace {

std::string_view without_scheme(std::string_view text) {
  for (const std::string_view scheme : {"tcp://", "mqtt://"})
    if (equal_ignoring_case(text.substr(0, scheme.size()), scheme)) {
      text.remove_prefix(scheme.size());
      if (text.ends_with('/')) text.remove_suffix(1);
      break;
    }
  return text;
}

std::optional<uint16_t> parse_port(std::string_view text) {
  const auto number = parse_unsigned(text);
  if (!number || *number == 0 || *number > std::numeric_limits<uint16_t>::max())
    return std::nullopt;
  return static_cast<uint16_t>(*number);
}

}  // namespace

HostText read_host(std::string_view text) {
  const std::string_view address = without_scheme(text);
  const size_t colon = address.rfind(':');
  const bool may_have_port = colon != std::string_view::npos && colon > 0 &&
                             (address.find(':') == colon || address[colon - 1] == ']');
  const auto port = may_have_port ? parse_port(address.substr(colon + 1)) : std::nullopt;
  return {std::string(port ? address.substr(0, colon) : address), port};
}

bool may_be_host(std::string_view text) {
  return std::none_of(text.begin(), text.end(), [](unsigned char c) { return c <= ' '; });
}

void read_address(std::string* host, uint32_t* port, uint32_t default_port) {
  const HostText read = read_host(*host);
  *host = read.host;
  if (read.port && *port == default_port) *port = *read.port;
}

}  // namespace weir::transport
