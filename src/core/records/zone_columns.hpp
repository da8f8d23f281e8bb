// The columns and rows in which tensor_zones adds to results: docs/results.md, "Zones".
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/zone/zone_counter.hpp"

namespace weir::records {

// The tables of a frame. Their rows have the score 0: other readers skip them.
inline constexpr char kZoneCountColumns[] =
    "score,zone,class,inside,entered,left,forward,backward,speed,ground-speed";
inline constexpr char kZoneEventColumns[] = "score,zone,event,class,track,dwell,speed,ground-speed";

// The columns of rows of objects, with those for `zones_per_object` zones appended.
std::string with_zone_columns(const std::string& columns, uint32_t zones_per_object);

// Where the numbers of a column are; -1 = the rows do not have it.
struct ColumnPlace {
  int32_t first = -1;
  uint32_t count = 0;
};
ColumnPlace find_column(std::string_view columns, std::string_view name);

// Columns of rows of objects.
struct ZoneColumns {
  ColumnPlace speed, ground_speed, zone, dwell;
  bool any() const noexcept { return speed.first >= 0 && zone.first >= 0; }
};
ZoneColumns zone_columns(std::string_view columns);

// Rows of kZoneCountColumns: the total of each zone, followed by each class. One row of zeros
// without zones.
void append_count_rows(const zone::ZoneCounter& counter, std::vector<float>* out);
// Rows of kZoneEventColumns; one row of zeros without events.
void append_event_rows(const zone::ZoneCounter& counter, std::vector<float>* out);
// The columns that with_zone_columns() appends to the row of an object: as many numbers as `out`
// has. Returns how many zones do not fit.
size_t write_zone_columns(const zone::ZoneCounter& counter, size_t sighting, std::span<float> out);

}  // namespace weir::records
