// Reads zones from JSON files; docs/zones.md and docs/schema/zones-1.schema.json define them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <string_view>

#include "core/zone/zone.hpp"
#include "weir/result.hpp"

namespace weir::zone {

// `place` names the text in errors. OPTION_VALUE lists every fault with the path of its member.
Result<ZoneSet> parse_zones(std::string_view text, const std::string& place);
// The same for a file. FILE_NOT_FOUND: it cannot be read, or is a folder.
Result<ZoneSet> read_zones(const std::string& path);

// Whether a file may have changed: its time, size and number (inode).
struct FileState {
  int64_t seconds = 0, nanoseconds = 0, size = -1;  // size -1: there is no file
  uint64_t number = 0;
  bool operator==(const FileState&) const = default;
};
FileState state_of_file(const std::string& path) noexcept;

}  // namespace weir::zone
