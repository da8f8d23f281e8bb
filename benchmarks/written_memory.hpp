// Measures the memory of a process for comparisons between processes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdlib>
#include <fstream>
#include <string>

namespace weir::bench {

// KiB of pages that only this process has written. Excludes code of libraries and weights that an
// engine maps, which are file-backed and shared, and untouched memory. Other processes do not
// affect it.
inline long written_kib() {
  std::ifstream rollup("/proc/self/smaps_rollup");
  for (std::string line; std::getline(rollup, line);)
    if (line.starts_with("Private_Dirty:")) return std::atol(line.c_str() + 14);
  return 0;
}

}  // namespace weir::bench
