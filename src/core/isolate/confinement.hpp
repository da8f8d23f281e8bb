// What a worker process takes away from itself before it touches a module or a model.
#pragma once
#include <cstdint>
#include <string>

namespace weir::isolate {

// For the one thread of a process that is about to become a worker. No network of this machine, no
// new programs, processes or sockets, no signals to others, at most `memory_mib` MiB of private
// memory (0 = no limit). Returns what of it the kernel allowed, in words.
std::string confine(uint64_t memory_mib);

}  // namespace weir::isolate
