// Zones of a picture: areas in which objects stay, and lines that they cross.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/zone/geometry.hpp"

namespace weir::zone {

inline constexpr size_t kZoneLimit = 10000;  // zones of a file
inline constexpr size_t kPointLimit = 1000;  // corners of a polygon

enum class Kind { Area, Line };

struct Zone {
  std::string name;
  Kind kind = Kind::Area;
  std::vector<Point> points{};  // pixels of the source picture; a line has two
  Reference reference = Reference::Bottom;
  double dwell = 0;  // of areas: seconds after which a stay is an event; 0 = never
  bool operator==(const Zone&) const;
};

struct ZoneSet {
  std::vector<Zone> zones;       // names are unique
  std::optional<Ground> ground;  // from pixels to metres
  std::string text;              // the JSON that it was parsed from
};

}  // namespace weir::zone
