// Counts the cores that this process may use.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

namespace weir {

// The recommended number of threads for a computation: physical cores of the affinity mask (threads
// of one core count once), reduced to the control group's quota; at least 1. `root` is prepended to
// /sys and /proc.
int usable_cores(const std::string& root = "");

}  // namespace weir
