// Runs a function that may crash in a forked process first.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <functional>
#include <string>

namespace weir::app {

// Returns "" when `load` returns in a copy of this process; otherwise a description of how the copy
// ended. The copy has ten seconds, prints nothing on standard output and leaves nothing behind.
std::string failure_of_load(const std::function<void()>& load);

}  // namespace weir::app
