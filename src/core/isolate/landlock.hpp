// Landlock: restricts access to files and to other processes, without any privilege.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

namespace weir::isolate {

// For a process with one thread and no_new_privs. It keeps access to the files of its user except
// those of other processes in /proc; it can read but not write /sys and the machine's files in
// /proc, lists folders, cannot create files in / itself, and can neither trace nor signal another
// process. Returns "" or the kernel's reason for refusing.
std::string restrict_files();

}  // namespace weir::isolate
