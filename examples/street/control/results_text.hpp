// Writes the results of a picture as a line of JSON, with the members that the comparison reads.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <span>
#include <string>

#include "core/zone/zone_counter.hpp"

namespace street {

struct Person {
  weir::Box box;  // pixels of the picture
  float score = 0;
  uint32_t track = 0;  // 0: not followed
};

// `time` in nanoseconds. The line ends with a line feed.
std::string results_text(int64_t time, std::span<const Person> people,
                         const weir::zone::ZoneCounter& counter);

}  // namespace street
