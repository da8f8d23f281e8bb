// Caps in a few words, for a label.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

namespace weir::app {

// Lines of a label: {"RGB 640x480", "30 fps"}, {"float32", "3:224:224"}, {"video/x-h264"}. None
// for text that is not caps.
std::vector<std::string> caps_lines(const std::string& caps);

}  // namespace weir::app
