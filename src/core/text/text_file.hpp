// Reads a text file that an option names, and the reason why a file cannot be read.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

namespace weir {

// The content of a text file of at most 16 MiB that `option` names. Throws Failure (FILE_NOT_FOUND)
// with the reason that the system gives.
std::string read_text_file(const std::string& option, const std::string& path);

// "it does not exist", "it is a folder" or "Permission denied", for example; empty for a file that
// can be read. Never opens a FIFO or device, which could wait.
std::string why_unreadable(const std::string& path);

}  // namespace weir
