// The system calls that a worker process may make, as a table.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <sys/types.h>

#include <array>
#include <cstdint>
#include <vector>

namespace weir::isolate {

// (argument & mask) == value. The kernel reads int arguments as 32 bits: their mask must not
// include higher bits, or a caller could pass a check with bits that the kernel ignores.
struct ArgumentCheck {
  uint8_t argument = 0;
  uint64_t mask = 0;  // 0: no check
  uint64_t value = 0;
};

struct SystemCallRule {
  long call = 0;
  int error = 0;  // errno for the caller; 0: allowed
  std::array<ArgumentCheck, 2> checks{};
};

// Among the adjacent rules for one call, the first whose checks all hold decides. Without one the
// call fails with EPERM; calls newer than kNewestCall fail with ENOSYS, so that the C library falls
// back to an older one. `self` is the process to be filtered. Empty: no table for this
// architecture.
std::vector<SystemCallRule> worker_rules(pid_t self);

// The newest call known to the table, of Linux 6.17. Numbers of the x32 ABI are larger.
constexpr uint32_t kNewestCall = 469;

}  // namespace weir::isolate
