// Finds columns by name.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/records/zone_columns.hpp"

#include "core/text/text.hpp"

namespace weir::records {

std::string with_zone_columns(const std::string& columns, uint32_t zones_per_object) {
  const std::string count = std::to_string(zones_per_object);
  return columns + ",speed,ground-speed,zone:" + count + ",dwell:" + count;
}

ColumnPlace find_column(std::string_view columns, std::string_view name) {
  uint64_t next = 0;
  for (const std::string_view entry : split(columns, ",")) {
    const size_t colon = entry.find(':');
    const std::string_view entry_name = entry.substr(0, colon);
    uint64_t count = 1;
    if (colon != std::string_view::npos)
      count = parse_unsigned(entry.substr(colon + 1)).value_or(0);
    if (entry_name == name) return {static_cast<int32_t>(next), static_cast<uint32_t>(count)};
    if (colon != std::string_view::npos && entry_name == "xy") count *= 2;
    if (colon != std::string_view::npos && entry_name == "xys") count *= 3;
    next += count;
  }
  return {};
}

ZoneColumns zone_columns(std::string_view columns) {
  ZoneColumns out{find_column(columns, "speed"), find_column(columns, "ground-speed"),
                  find_column(columns, "zone"), find_column(columns, "dwell")};
  if (out.zone.count != out.dwell.count) out = {};
  return out;
}

}  // namespace weir::records
