// Namespaces and capabilities: reduces the rights of a worker process.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

namespace weir::isolate {

// The kernel's reason for refusing each step; "" on success.
struct Namespaces {
  std::string user, network;
};

// Moves this process, which has one thread, into new user, network and IPC namespaces. It keeps its
// user and group; the namespace has no others.
Namespaces enter_namespaces();

// Permanently drops every capability and prevents tracing and core dumps of this process. Returns
// "" or the kernel's reason for refusing.
std::string drop_privileges();

}  // namespace weir::isolate
