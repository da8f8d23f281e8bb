// Namespaces and capabilities: what a worker process has of the rights of its user.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

namespace weir::isolate {

// What the kernel refused, in words; "" where it was done.
struct Namespaces {
  std::string user, network;
};

// Moves this process, which has one thread, into a user namespace with a network (and IPC) of its
// own. It stays the user and the group that it was; there are no others in its namespace.
Namespaces enter_namespaces();

// Drops every capability, for ever, and lets nobody trace this process or get its memory in a core
// dump. Returns "" or why the kernel refused.
std::string drop_privileges();

}  // namespace weir::isolate
