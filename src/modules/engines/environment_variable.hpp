// Sets an environment variable while other threads read the environment.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

namespace weir::engine {

// Adds `assignment`, "NAME=value", which must never be freed; a variable that is already set keeps
// its value. Unlike setenv(), this changes and frees nothing that a concurrent reader sees: a
// longer copy replaces the environment in one step, and the old one stays allocated. Calls are
// serialised. As always, no thread may call setenv() or putenv() at the same time.
void add_environment_variable(const char* assignment);

}  // namespace weir::engine
