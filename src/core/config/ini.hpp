// Files of groups and keys: weir.ini, and others of that syntax.
//
//   # a comment
//   [filter]
//   priority_tflite = tensorflow-lite, onnxruntime
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "weir/result.hpp"

namespace weir::config {

struct IniEntry {
  std::string group, key, value;  // without blanks around them
  size_t line = 0;                // from 1
};

// What could be read, and a fault for each line that could not: OPTION_SYNTAX with "NAME:LINE".
struct Ini {
  std::vector<IniEntry> entries;  // in the order of the lines
  std::vector<Error> faults;
};

// At most 1 MiB, 4096 bytes a line, 4096 entries, 16 faults: the rest is one more fault.
Ini parse_ini(std::string_view text, const std::string& name);
// FILE_NOT_FOUND as the fault when the file cannot be read.
Ini read_ini(const std::string& path);

// "1", "true", "yes", "on" and what begins so, in any case; "0", "false", "no", "off"; else
// `otherwise` (specification 8.1).
bool truth(std::string_view text, bool otherwise) noexcept;

}  // namespace weir::config
