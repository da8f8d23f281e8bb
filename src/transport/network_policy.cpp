// SPDX-License-Identifier: LGPL-2.1-or-later
#include "transport/network_policy.hpp"

#include <gio/gio.h>

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "core/config/ini.hpp"
#include "machine/loopback.hpp"

namespace weir::transport {
namespace {

struct Unreference {
  void operator()(gpointer object) const { g_object_unref(object); }
};
using Address = std::unique_ptr<GInetAddress, Unreference>;
using Network = std::unique_ptr<GInetAddressMask, Unreference>;

std::string without_brackets(std::string_view host) {
  if (host.size() > 2 && host.front() == '[' && host.back() == ']')
    host = host.substr(1, host.size() - 2);
  return std::string(host);
}

Address address_from_text(std::string_view host) {
  return Address{g_inet_address_new_from_string(without_brackets(host).c_str())};
}

std::vector<std::string> split_entries(std::string_view allow) {
  std::vector<std::string> out;
  while (!allow.empty()) {
    const size_t comma = std::min(allow.find(','), allow.size());
    std::string_view entry = allow.substr(0, comma);
    while (!entry.empty() && entry.front() == ' ') entry.remove_prefix(1);
    while (!entry.empty() && entry.back() == ' ') entry.remove_suffix(1);
    if (!entry.empty()) out.push_back(without_brackets(entry));
    allow.remove_prefix(std::min(comma + 1, allow.size()));
  }
  return out;
}

Network network_from_text(const std::string& entry) {
  return Network{g_inet_address_mask_new_from_string(entry.c_str(), nullptr)};
}

bool is_host_name(const std::string& entry) {
  // An address that is not complete has digits and dots alone.
  return std::any_of(entry.begin(), entry.end(), [](char c) { return g_ascii_isalpha(c); }) &&
         std::all_of(entry.begin(), entry.end(),
                     [](char c) { return g_ascii_isalnum(c) || c == '.' || c == '-' || c == '_'; });
}

bool names(const std::string& entry, const std::string& peer) {
  if (g_ascii_strcasecmp(entry.c_str(), peer.c_str()) == 0) return true;
  const Network network = network_from_text(entry);
  const Address address = address_from_text(peer);
  return network && address && g_inet_address_mask_matches(network.get(), address.get());
}

bool is_exposed(const Endpoint& endpoint) {
  return !endpoint.encrypted && !is_loopback(endpoint.host);
}

Error insecure_error(const Endpoint& endpoint, std::string needed, std::string fix) {
  const bool listens = endpoint.role == Role::Listens;
  return {.code = Code::CONNECTION_INSECURE,
          .what = listens ? "other machines can connect without encryption"
                          : "the connection to another machine is not encrypted",
          .offered = (listens ? "listening on " : "connecting to ") + endpoint.to_string(),
          .needed = std::move(needed),
          .fix = std::move(fix)};
}

std::string encrypting_fix(const Endpoint& endpoint) {
  return endpoint.tls_fix.empty() ? "host=127.0.0.1 and a stunnel to the other machine"
                                  : endpoint.tls_fix;
}

}  // namespace

std::string Endpoint::to_string() const {
  const bool bare_v6 = host.find(':') != std::string::npos && host.front() != '[';
  const std::string shown = host.empty() ? "0.0.0.0" : host;
  return (bare_v6 ? "[" + shown + "]" : shown) + ":" + std::to_string(port);
}

bool is_allowed(std::string_view allow, std::string_view peer) {
  const auto entries = split_entries(allow);
  const std::string bare = without_brackets(peer);
  return allow.empty() || std::any_of(entries.begin(), entries.end(),
                                      [&](const auto& entry) { return names(entry, bare); });
}

Status check_allow_list(std::string_view allow) {
  const auto unusable = [](const char* what, std::string offered) {
    return Error{.code = Code::OPTION_VALUE,
                 .what = what,
                 .offered = std::move(offered),
                 .needed = "host names, addresses, and networks, separated by commas",
                 .fix = "allow=192.168.1.0/24,camera.local"};
  };
  const auto entries = split_entries(allow);
  // As of allow="$CAMERA,$VIEWER" without the variables: not a list that names every peer.
  if (!allow.empty() && entries.empty())
    return unusable("the property allow has no entry", "allow=\"" + std::string(allow) + "\"");
  for (const auto& entry : entries)
    if (!is_host_name(entry) && !network_from_text(entry))
      return unusable("an entry of the property allow cannot be read", entry);
  return ok();
}

Status check_server_is_allowed(const Endpoint& endpoint) {
  const auto names_this_machine = [&] {
    const auto names = {"localhost", "127.0.0.1", "::1"};
    return std::any_of(names.begin(), names.end(),
                       [&](const char* name) { return is_allowed(endpoint.allow, name); });
  };
  if (auto status = check_allow_list(endpoint.allow); !status) return status;
  if (is_allowed(endpoint.allow, endpoint.host)) return ok();
  if (is_loopback(endpoint.host) && names_this_machine()) return ok();
  return Error{.code = Code::CONNECTION_INSECURE,
               .what = "the property allow does not name the server",
               .offered = "connecting to " + endpoint.to_string() + " with allow=" + endpoint.allow,
               .needed = "its host name as it is given, its address, or a network with its address",
               .fix = "allow=" + endpoint.allow + "," + endpoint.host};
}

Status check_own_protocol(const Endpoint& endpoint) {
  if (!is_exposed(endpoint) || endpoint.insecure) return ok();
  return insecure_error(endpoint, "TLS, or insecure=true on a network that you trust",
                        encrypting_fix(endpoint));
}

Result<std::optional<Error>> check_old_protocol(const Endpoint& endpoint,
                                                const config::Configuration& configuration) {
  if (auto status = check_allow_list(endpoint.allow); !status) return status.error();
  if (!is_exposed(endpoint)) return std::optional<Error>{};
  const auto setting = configuration.find("network", "require-tls");
  const bool required = setting && config::truth(setting->value, false);
  if (!required)
    return std::optional<Error>{
        insecure_error(endpoint, "TLS, or a network that you trust", encrypting_fix(endpoint))};
  const bool allowed = endpoint.role == Role::Listens || is_allowed(endpoint.allow, endpoint.host);
  if (endpoint.insecure && !split_entries(endpoint.allow).empty() && allowed)
    return std::optional<Error>{};
  const std::string peer = endpoint.role == Role::Listens ? "192.168.1.0/24" : endpoint.host;
  return insecure_error(
      endpoint,
      "TLS, or insecure=true and allow= with the peers, because [network] "
      "require-tls of " +
          setting->origin + " is " + setting->value,
      (endpoint.tls_fix.empty() ? "" : endpoint.tls_fix + ", or ") + "insecure=true allow=" + peer);
}

}  // namespace weir::transport
