// The members of JSON Lines about zones: docs/results.md.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "core/records/record_writer.hpp"

namespace weir::records {

// ,"speed":..,"ground_speed":..,"zones":[{"name":..,"dwell":..}] of an object; what is not known is
// left out.
void append_zones_of(const WriterSettings& settings, const ResultFrame& frame,
                     const ResultObject& object, std::string* out);
// ,"zones":[..],"events":[..] of a frame.
void append_zones_and_events(const WriterSettings& settings, const ResultFrame& frame,
                             std::string* out);

}  // namespace weir::records
