// Compares numbers, never what a name resolves to.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "loopback.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <strings.h>

#include <string>

namespace weir {

bool is_loopback(std::string_view host) {
  if (host.size() > 2 && host.front() == '[' && host.back() == ']')
    host = host.substr(1, host.size() - 2);
  if (host.find('\0') != std::string_view::npos) return false;  // C functions would stop there
  const std::string bare(host);
  if (strcasecmp(bare.c_str(), "localhost") == 0) return true;
  in_addr v4{};
  if (inet_pton(AF_INET, bare.c_str(), &v4) == 1)
    return (ntohl(v4.s_addr) >> IN_CLASSA_NSHIFT) == IN_LOOPBACKNET;
  in6_addr v6{};
  return inet_pton(AF_INET6, bare.c_str(), &v6) == 1 && IN6_IS_ADDR_LOOPBACK(&v6);
}

}  // namespace weir
