// MachineInfo: the processor, graphics processors and memory of this machine.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace weir::app {

struct MachineInfo {
  std::string processor;  // its model, or its architecture where the kernel gives no name
  int cores = 1;          // that this process may use
  std::vector<std::string> gpus;
  uint64_t memory_bytes = 0, available_bytes = 0;  // 0: not known
};

// `root` is prepended to /proc and /sys.
MachineInfo get_machine_info(const std::string& root = "");

}  // namespace weir::app
