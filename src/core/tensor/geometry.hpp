// Size and Rect: of pictures, grids and parts of them, in whole pixels or elements.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>

namespace weir {

struct Size {
  uint32_t width = 0, height = 0;
  bool operator==(const Size&) const = default;
};

// x and y: the upper left corner.
struct Rect {
  uint32_t x = 0, y = 0, width = 0, height = 0;
  bool operator==(const Rect&) const = default;
};

}  // namespace weir
