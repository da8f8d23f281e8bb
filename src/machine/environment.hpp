// environment_variable: reads the environment only if the process may trust it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdlib>

namespace weir {

// Null if the variable is not set, and always in a program with more rights than the user who
// starts it (set-user-ID, set-group-ID, file capabilities): there, variables must not choose code
// to load or files to read.
inline const char* environment_variable(const char* name) noexcept {
  return secure_getenv(name);
}

}  // namespace weir
