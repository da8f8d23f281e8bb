// Writes the results of a picture as a line of JSON, with the members that the comparison reads.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <span>
#include <string>

#include "core/zone/zone_counter.hpp"
#include "detector.hpp"

namespace street {

// `time` in nanoseconds. The line ends with a line feed.
std::string results_text(int64_t time, std::span<const Detection> people,
                         const weir::zone::ZoneCounter& counter);

}  // namespace street
