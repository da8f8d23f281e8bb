// Asks GLib's resolver.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "transport/mqtt/broker_address.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <memory>

namespace weir::transport {
namespace {

std::string text_of(GInetAddress* address) {
  const std::unique_ptr<char, decltype(&g_free)> text(g_inet_address_to_string(address), g_free);
  return text.get();
}

}  // namespace

std::vector<std::string> addresses_of(const std::string& host, GCancellable* cancellable,
                                      std::string* reason) {
  GError* error = nullptr;
  const std::unique_ptr<GResolver, decltype(&g_object_unref)> resolver(g_resolver_get_default(),
                                                                       g_object_unref);
  GList* found = g_resolver_lookup_by_name(resolver.get(), host.c_str(), cancellable, &error);
  std::vector<std::string> out;
  for (GList* item = found; item; item = item->next)
    out.push_back(text_of(G_INET_ADDRESS(item->data)));
  g_resolver_free_addresses(found);
  if (error) *reason = error->message;
  g_clear_error(&error);
  return out;
}

std::string local_address_of(int socket) {
  sockaddr_storage storage{};
  socklen_t length = sizeof storage;
  auto* address = reinterpret_cast<sockaddr*>(&storage);
  if (socket < 0 || getsockname(socket, address, &length) != 0) return "";
  char text[INET6_ADDRSTRLEN] = "";
  if (storage.ss_family == AF_INET)
    inet_ntop(AF_INET, &reinterpret_cast<sockaddr_in*>(&storage)->sin_addr, text, sizeof text);
  if (storage.ss_family == AF_INET6)
    inet_ntop(AF_INET6, &reinterpret_cast<sockaddr_in6*>(&storage)->sin6_addr, text, sizeof text);
  return text;
}

}  // namespace weir::transport
