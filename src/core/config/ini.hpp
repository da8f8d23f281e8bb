// Parser of ini files with groups and keys, such as weir.ini.
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
  std::string group, key, value;  // without surrounding blanks
  size_t line = 0;                // starts at 1
};

// The readable entries, and a fault for each unreadable line: OPTION_SYNTAX with "NAME:LINE".
struct Ini {
  std::vector<IniEntry> entries;  // in the order of the lines
  std::vector<Error> faults;
};

// Reads at most 1 MiB, 4096 bytes per line, 4096 entries and 16 faults; anything more is one fault.
Ini parse_ini(std::string_view text, const std::string& name);
// If the file cannot be read, the fault is FILE_NOT_FOUND.
Ini read_ini(const std::string& path);

// True for texts that begin with "1", "true", "yes" or "on", in any case; false for "0", "false",
// "no" and "off"; else `otherwise` (docs/compatibility/app-api.md 8.1).
bool truth(std::string_view text, bool otherwise) noexcept;

}  // namespace weir::config
