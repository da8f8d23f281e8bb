// The reason why a file cannot be read.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

#include <string>

namespace weir {

// "it does not exist", "it is a folder" or "Permission denied", for example; empty for a file that
// can be read. Never opens a FIFO or device, which could wait.
std::string why_unreadable(const std::string& path);

}  // namespace weir
