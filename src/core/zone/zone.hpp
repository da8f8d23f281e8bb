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
inline constexpr double kLineMargin = 0.1;   // of lines in a file that gives none

enum class Kind { Area, Line };

struct Zone {
  std::string name;
  Kind kind = Kind::Area;
  std::vector<Point> points{};  // pixels of the source picture; a line has two
  Reference reference = Reference::Bottom;
  double dwell = 0;  // of areas: seconds after which a stay is an event; 0 = never
  // How far from its border an object is clearly on one side, as a part of the longer side of its
  // box: until then it does not leave an area, and its next crossing of a line waits.
  double margin = 0;
  bool operator==(const Zone&) const;
};

struct ZoneSet {
  std::vector<Zone> zones;       // names are unique
  std::optional<Ground> ground;  // from pixels to metres
  std::string text;              // the JSON that it was parsed from
};

}  // namespace weir::zone
