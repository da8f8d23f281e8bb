// Reads and checks what a server's security needs.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "net/server_security.hpp"

#include <fstream>
#include <iterator>
#include <sstream>

namespace weir::net {
namespace {

Result<std::string> read_file(const std::string& path, const char* property) {
  std::ifstream in(path, std::ios::binary);
  std::string out{std::istreambuf_iterator<char>(in), {}};
  if (in && !out.empty()) return out;
  return Error{.code = Code::FILE_NOT_FOUND,
               .what = std::string("the file of the property ") + property + " cannot be read",
               .offered = path,
               .needed = "a file with text",
               .fix = std::string(property) + "=/path/to/file"};
}

Status check_options(const ListenOptions& options) {
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
                 .what = "clients have no certificates on connections without TLS",
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

// Compares without an end at the first difference, which would show how much of a guess is right.
bool same_text(std::string_view one, std::string_view other) {
  if (one.size() != other.size()) return false;
  volatile unsigned char difference = 0;
  for (size_t i = 0; i < one.size(); ++i)
    difference = difference | static_cast<unsigned char>(one[i] ^ other[i]);
  return difference == 0;
}

}  // namespace

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

Result<ServerSecrets> read_secrets(const ListenOptions& options) {
  if (auto status = check_options(options); !status) return status.error();
  ServerSecrets out;
  std::string tokens;
  const ServerSecurity& security = options.security;
  const struct {
    const std::string& path;
    const char* property;
    std::string* text;
  } files[] = {{security.cert, "tls-cert", &out.cert},
               {security.key, "tls-key", &out.key},
               {security.ca, "tls-ca", &out.ca},
               {security.token_file, "token-file", &tokens}};
  for (const auto& file : files) {
    if (file.path.empty()) continue;
    auto text = read_file(file.path, file.property);
    if (!text) return text.error();
    *file.text = *std::move(text);
  }
  std::istringstream lines(tokens);
  for (std::string line; std::getline(lines, line);) {
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (!line.empty()) out.tokens.push_back(line);
  }
  if (!security.token_file.empty() && out.tokens.empty())
    return Error{.code = Code::OPTION_VALUE,
                 .what = "the file of the property token-file has no token",
                 .offered = security.token_file,
                 .needed = "one token on each line",
                 .fix = "openssl rand -hex 32 > " + security.token_file};
  return out;
}

bool has_token(const ServerSecrets& secrets, std::string_view header) {
  constexpr std::string_view kScheme = "Bearer ";
  if (header.substr(0, kScheme.size()) != kScheme) return false;
  bool known = false;
  for (const auto& token : secrets.tokens)
    known = same_text(header.substr(kScheme.size()), token) || known;
  return known;
}

}  // namespace weir::net
