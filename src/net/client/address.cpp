// Parses the addresses of models on servers.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "net/client/link.hpp"

#include <charconv>
#include <optional>

#include "machine/loopback.hpp"

namespace weir::net {
namespace {

constexpr size_t kMaxTextBytes = 1024;

Error bad_address(std::string_view text, std::string difference) {
  return {.code = Code::OPTION_VALUE,
          .what = "the address of a model on a server cannot be read",
          .offered = std::string(text.substr(0, kMaxTextBytes)),
          .needed =
              "grpc://HOST:PORT/MODEL or grpcs://HOST:PORT/MODEL, optionally followed by /VERSION",
          .difference = std::move(difference),
          .fix = "model=grpc://127.0.0.1:8001/resnet/1"};
}

// Removes `prefix` from the text if it is there.
bool take(std::string_view* text, std::string_view prefix) {
  if (text->substr(0, prefix.size()) != prefix) return false;
  text->remove_prefix(prefix.size());
  return true;
}

bool is_port(std::string_view text) {
  int port = 0;
  const auto [end, bad] = std::from_chars(text.data(), text.data() + text.size(), port);
  return bad == std::errc{} && end == text.data() + text.size() && port > 0 && port < 65536;
}

// Splits "host:port" and says what is wrong with it; "" = nothing.
std::string check_host(std::string_view authority, std::string_view* host) {
  const size_t colon = authority.rfind(':');
  if (colon == std::string_view::npos || colon == 0) return "no host and port";
  *host = authority.substr(0, colon);
  if (!is_port(authority.substr(colon + 1))) return "the port is not a number from 1 to 65535";
  const bool bracketed = host->front() == '[' && host->back() == ']';
  if (!bracketed && host->find_first_of(":[]@") != std::string_view::npos)
    return "an IPv6 address needs brackets: [::1]:8001";
  return "";
}

std::optional<std::string> read_model(std::string_view path, ServerAddress* out) {
  const size_t slash = path.find('/');
  out->model = path.substr(0, slash);
  if (slash != std::string_view::npos) out->version = path.substr(slash + 1);
  if (out->model.empty()) return "no model name";
  if (out->version.find('/') != std::string::npos) return "more than a model and a version";
  return std::nullopt;
}

}  // namespace

Result<ServerAddress> ServerAddress::parse(std::string_view text) {
  ServerAddress out;
  std::string_view rest = text;
  if (text.size() > kMaxTextBytes) return bad_address(text, "it is longer than 1024 characters");
  out.text = text;
  if (take(&rest, "grpc+unix:")) {
    const size_t end = rest.rfind(":/");
    if (end == std::string_view::npos || end == 0)
      return bad_address(text, "no socket and model, as in grpc+unix:/run/weir.sock:/resnet");
    out.target = "unix:" + std::string(rest.substr(0, end));
    out.local = true;
    if (const auto wrong = read_model(rest.substr(end + 2), &out)) return bad_address(text, *wrong);
    return out;
  }
  out.encrypted = take(&rest, "grpcs:");
  if (!out.encrypted && !take(&rest, "grpc:"))
    return bad_address(text, "it does not begin with grpc: or grpcs:");
  const bool named = take(&rest, "dns:///");
  if (!named && !take(&rest, "//")) return bad_address(text, "no // after the scheme");
  const size_t slash = rest.find('/');
  if (slash == std::string_view::npos) return bad_address(text, "no model name");
  std::string_view host;
  if (const auto wrong = check_host(rest.substr(0, slash), &host); !wrong.empty())
    return bad_address(text, wrong);
  out.target = (named ? "dns:///" : "") + std::string(rest.substr(0, slash));
  out.local = is_loopback(host);
  if (const auto wrong = read_model(rest.substr(slash + 1), &out)) return bad_address(text, *wrong);
  return out;
}

}  // namespace weir::net
