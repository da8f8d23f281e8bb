// Setting an environment variable while other threads read the environment.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

namespace weir::engine {

// Sets NAME to the value in `assignment`, "NAME=value", which lives for ever; a variable that is
// set already stays as it is. Unlike setenv(), it changes and frees nothing that a concurrent
// reader sees: the environment is replaced by a longer copy in one step, and the old one stays.
// Calls are serialised. A thread that calls setenv() or putenv() at the same time must not exist,
// as always.
void add_environment_variable(const char* assignment);

}  // namespace weir::engine
