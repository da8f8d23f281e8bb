// The seccomp filter of a worker process: rules for system calls as a program of classic BPF.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <linux/filter.h>

#include <span>
#include <string>
#include <vector>

#include "core/isolate/system_call_rules.hpp"

namespace weir::isolate {

// The program for seccomp(2). Rules for one call stand in a row.
std::vector<sock_filter> compile(std::span<const SystemCallRule> rules);

// Puts the filter for workers on all threads of this process, which has no_new_privs, for ever.
// Returns "" or why the kernel refused.
std::string filter_system_calls();

}  // namespace weir::isolate
