// Tries the places around a box in turn.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/draw/label_layout.hpp"

#include <algorithm>

namespace weir::draw {

bool LabelLayout::is_free(const Area& area) const {
  return std::none_of(taken_.begin(), taken_.end(),
                      [&](const Area& other) { return !common_part(area, other).empty(); });
}

Area LabelLayout::place(const Area& box, int64_t width, int64_t height, int64_t step) {
  const Area seen = common_part(box, picture_);
  if (seen.empty()) return {};
  const auto aligned = [step](int64_t at) { return at / step * step; };
  const int64_t x = aligned(std::max(std::min(seen.left, picture_.right - width), picture_.left));
  const int64_t tops[] = {box.top - height,     seen.top,
                          box.bottom,           seen.bottom - height,
                          box.top - 2 * height, box.bottom + height,
                          box.top - 3 * height, box.bottom + 2 * height,
                          box.top - 4 * height, box.bottom + 3 * height};
  for (int64_t top : tops) {
    top = aligned(top);
    if (top < picture_.top || (top + height > picture_.bottom && top > picture_.top)) continue;
    const Area area{x, top, x + width, top + height};
    if (!is_free(area)) continue;
    taken_.push_back(area);
    return area;
  }
  return {};
}

}  // namespace weir::draw
