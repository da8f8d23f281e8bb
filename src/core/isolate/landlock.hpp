// Landlock: a process gives up files, and the right to reach other processes, without any
// SPDX-License-Identifier: LGPL-2.1-or-later
// privilege.
#pragma once
#include <string>

namespace weir::isolate {

// For a process with one thread and no_new_privs. From here on it uses the files of its user except
// the files of other processes in /proc, reads /sys and what /proc says of the machine without
// writing them, lists folders, creates nothing in / itself, and neither traces nor signals another
// process. Returns "" or why the kernel refused.
std::string restrict_files();

}  // namespace weir::isolate
