// The cores that this process may use.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

namespace weir {

// How many threads a computation of this process should use. Physical cores of the affinity mask
// (threads of one core count once), less where the control group's quota allows less; at least 1.
// `root` stands before /sys and /proc.
int usable_cores(const std::string& root = "");

}  // namespace weir
