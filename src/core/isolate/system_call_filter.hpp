// The seccomp filter of a worker process: compiles system call rules to classic BPF.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <linux/filter.h>

#include <span>
#include <string>
#include <vector>

#include "core/isolate/system_call_rules.hpp"

namespace weir::isolate {

// A program for seccomp(2). Precondition: rules for one call are adjacent.
std::vector<sock_filter> compile(std::span<const SystemCallRule> rules);

// Permanently installs the filter for workers on all threads of this process, which must have
// no_new_privs. Returns "" or the kernel's reason for refusing.
std::string filter_system_calls();

}  // namespace weir::isolate
