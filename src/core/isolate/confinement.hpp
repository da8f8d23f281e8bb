// What a worker process gives up before it touches a module or a model.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <string>

namespace weir::isolate {

struct Confinement {
  std::string text;     // each restriction, or what remains where the kernel refused it and why
  std::string refused;  // the latter alone; "" = every restriction holds
};

// For the one thread of a process that is about to become a worker. Restricts it for ever to its
// own memory and threads and the files of its user: no network, no new programs, processes or
// sockets, no capabilities, no reach into other processes, at most `memory_mib` MiB of private
// memory (0 = no limit).
Confinement confine(uint64_t memory_mib);

}  // namespace weir::isolate
