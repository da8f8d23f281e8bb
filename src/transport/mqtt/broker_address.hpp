// Addresses of a host name, looked up so that another thread can end it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gio/gio.h>

#include <string>
#include <vector>

namespace weir::transport {

// Addresses as text, in the order of the resolver; empty with `*reason` if there are none.
std::vector<std::string> addresses_of(const std::string& host, GCancellable* cancellable,
                                      std::string* reason);
// The address of this machine on a connected socket, or "".
std::string local_address_of(int socket);

}  // namespace weir::transport
