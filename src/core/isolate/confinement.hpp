// The restrictions that a worker process applies to itself before it loads a module or a model.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <string>

namespace weir::isolate {

struct Confinement {
  std::string text;     // each restriction, or what is still possible and the kernel's reason
  std::string refused;  // only the latter; "" = every restriction is in effect
};

// For the only thread of a process that is about to become a worker. Permanently restricts it to
// its own memory and threads and the files of its user: no network, no new programs, processes or
// sockets, no capabilities, no access to other processes, at most `memory_mib` MiB of private
// memory (0 = no limit).
Confinement confine(uint64_t memory_mib);

}  // namespace weir::isolate
