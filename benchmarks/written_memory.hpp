// The memory of a process that counts when two are compared.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdlib>
#include <fstream>
#include <string>

namespace weir::bench {

// KiB of pages that this process alone wrote: neither a library's code nor weights that an engine
// maps, which are read from their files and are there once for all, nor memory that was never
// touched. What else runs on the machine changes nothing in it.
inline long written_kib() {
  std::ifstream rollup("/proc/self/smaps_rollup");
  for (std::string line; std::getline(rollup, line);)
    if (line.starts_with("Private_Dirty:")) return std::atol(line.c_str() + 14);
  return 0;
}

}  // namespace weir::bench
