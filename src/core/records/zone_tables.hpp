// Writes what a ZoneCounter found as the numbers of results: docs/results.md, "Zones".
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "core/zone/zone_counter.hpp"

namespace weir::records {

// Rows of kZoneCountColumns: the total of each zone, followed by each class. One row of zeros
// without zones.
void append_count_rows(const zone::ZoneCounter& counter, std::vector<float>* out);
// Rows of kZoneEventColumns; one row of zeros without events.
void append_event_rows(const zone::ZoneCounter& counter, std::vector<float>* out);
// The columns that with_zone_columns() appends to the row of an object: as many numbers as `out`
// has. Returns how many zones do not fit.
size_t write_zone_columns(const zone::ZoneCounter& counter, size_t sighting, std::span<float> out);

}  // namespace weir::records
