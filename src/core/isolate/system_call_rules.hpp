// What a worker process may ask of the kernel, as data.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <sys/types.h>

#include <array>
#include <cstdint>
#include <vector>

namespace weir::isolate {

// (argument & mask) == value. The kernel reads arguments of type int as 32 bits: their mask must
// not reach beyond, or a caller could pass a check with bits that the kernel drops.
struct ArgumentCheck {
  uint8_t argument = 0;
  uint64_t mask = 0;  // 0: no check
  uint64_t value = 0;
};

struct SystemCallRule {
  long call = 0;
  int error = 0;  // what the caller gets; 0: the call is made
  std::array<ArgumentCheck, 2> checks{};
};

// Of the rules for one call, which stand in a row, the first whose checks all hold decides. EPERM
// answers a call that no rule allows, ENOSYS one that is newer than kNewestCall: the C library then
// uses an older one. `self` is the process that the filter is for. Empty: this architecture has no
// table.
std::vector<SystemCallRule> worker_rules(pid_t self);

// The newest call that the table was written with, of Linux 6.17. Numbers of the x32 ABI are
// larger.
constexpr uint32_t kNewestCall = 469;

}  // namespace weir::isolate
