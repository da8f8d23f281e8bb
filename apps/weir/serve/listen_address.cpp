// SPDX-License-Identifier: LGPL-2.1-or-later
#include "serve/listen_address.hpp"

#include <charconv>
#include <string_view>

namespace weir::app {
namespace {

bool is_port(std::string_view text) {
  int port = 0;
  const auto [end, bad] = std::from_chars(text.data(), text.data() + text.size(), port);
  return bad == std::errc{} && end == text.data() + text.size() && port >= 0 && port < 65536;
}

}  // namespace

Result<ListenAddress> ListenAddress::parse(const std::string& text, const char* option) {
  constexpr std::string_view kUnix = "unix:";
  ListenAddress out;
  if (text.starts_with(kUnix) && text.size() > kUnix.size()) {
    out.unix_path = text.substr(kUnix.size());
    return out;
  }
  const size_t colon = text.rfind(':');
  if (colon != std::string::npos && colon > 0 && is_port(text.substr(colon + 1))) {
    out.host = text.substr(0, colon);
    out.port = text.substr(colon + 1);
    const bool bracketed = out.host.front() == '[' && out.host.back() == ']';
    if (bracketed) out.host = out.host.substr(1, out.host.size() - 2);
    if (bracketed || out.host.find_first_of(":[] ") == std::string::npos) return out;
  }
  return Error{.code = Code::OPTION_VALUE,
               .what = std::string("the address of ") + option + " cannot be read",
               .offered = "'" + text + "'",
               .needed = "HOST:PORT, [ADDRESS]:PORT for IPv6, or unix:PATH",
               .fix = std::string(option) + " 127.0.0.1:8001"};
}

std::string ListenAddress::text() const {
  if (!unix_path.empty()) return "unix:" + unix_path;
  return (host.find(':') == std::string::npos ? host : "[" + host + "]") + ":" + port;
}

bool ListenAddress::is_local() const {
  return !unix_path.empty() || host == "localhost" || host == "::1" ||
         (host.starts_with("127.") && host.find_first_not_of("0123456789.") == std::string::npos);
}

}  // namespace weir::app
