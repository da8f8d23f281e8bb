// Fuzz target: parses files of groups and keys. Results are within the bounds and have the right
// line.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "core/config/ini.hpp"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto ini = weir::config::parse_ini(text, "fuzz");
  const auto lines = static_cast<size_t>(std::count(text.begin(), text.end(), '\n')) + 1;
  if (ini.entries.size() > 4096 || ini.faults.size() > 17) std::abort();
  size_t before = 0;
  for (const auto& entry : ini.entries) {
    if (entry.group.empty() || entry.key.empty() || entry.line <= before || entry.line > lines)
      std::abort();
    before = entry.line;
  }
  return 0;
}
