// SPDX-License-Identifier: LGPL-2.1-or-later
#include "net/server/server_security.hpp"

namespace weir::net {

Status check_security(const ListenOptions& options) {
  const ServerSecurity& security = options.security;
  const bool encrypted = !security.cert.empty();
  if (security.cert.empty() != security.key.empty())
    return Error{.code = Code::OPTION_VALUE,
                 .what = "a certificate and its key belong together",
                 .offered = encrypted ? "tls-cert without tls-key" : "tls-key without tls-cert",
                 .needed = "both",
                 .fix = "tls-cert=server.pem tls-key=server.key"};
  if (!encrypted && !security.ca.empty())
    return Error{.code = Code::OPTION_VALUE,
                 .what = "client certificates need a connection with TLS",
                 .offered = "tls-ca without tls-cert and tls-key",
                 .needed = "a certificate of this server",
                 .fix = "tls-cert=server.pem tls-key=server.key tls-ca=" + security.ca};
  if (security.ca.empty() && !security.peers.empty())
    return Error{.code = Code::OPTION_VALUE,
                 .what = "the names of clients are not verified",
                 .offered = "tls-peers without tls-ca",
                 .needed = "the authority of the clients' certificates",
                 .fix = "tls-ca=ca.pem"};
  if (!encrypted && !security.token_file.empty())
    return Error{.code = Code::CONNECTION_INSECURE,
                 .what = "clients would send their tokens without TLS",
                 .offered = "token-file without tls-cert and tls-key",
                 .needed = "a certificate of this server",
                 .fix = "tls-cert=server.pem tls-key=server.key"};
  if (!encrypted && !is_local(options) && !security.insecure)
    return Error{.code = Code::CONNECTION_INSECURE,
                 .what = "other machines could connect without encryption",
                 .offered = "listening on " + address_text(options),
                 .needed = "TLS, or insecure=true on a network that you trust",
                 .fix = "tls-cert=server.pem tls-key=server.key, or host=localhost"};
  return ok();
}

bool is_local(const ListenOptions& options) {
  const std::string& host = options.host;
  return !options.unix_path.empty() || host == "localhost" || host == "::1" || host == "[::1]" ||
         (host.rfind("127.", 0) == 0 && host.find_first_not_of("0123456789.") == std::string::npos);
}

std::string address_text(const ListenOptions& options) {
  if (!options.unix_path.empty()) return "unix:" + options.unix_path;
  const bool bare_v6 = options.host.find(':') != std::string::npos && options.host.front() != '[';
  return (bare_v6 ? "[" + options.host + "]" : options.host) + ":" + std::to_string(options.port);
}

}  // namespace weir::net
