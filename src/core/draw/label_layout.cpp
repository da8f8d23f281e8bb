// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/draw/label_layout.hpp"

#include <algorithm>

namespace weir::draw {

bool LabelLayout::is_free(const Area& area) const {
  return std::none_of(taken_.begin(), taken_.end(),
                      [&](const Area& other) { return !common_part(area, other).empty(); });
}

// An empty area unless the place is in the picture and free.
Area LabelLayout::take(int64_t x, int64_t top, int64_t width, int64_t height) {
  if (top < picture_.top || (top + height > picture_.bottom && top > picture_.top)) return {};
  const Area area{x, top, x + width, top + height};
  if (!is_free(area)) return {};
  taken_.push_back(area);
  return area;
}

Area LabelLayout::place_in_list(const Area& box, int64_t width, int64_t height, int64_t step) {
  const Area seen = common_part(box, picture_);
  const int64_t x = std::max(std::min(seen.left, picture_.right - width), picture_.left);
  for (int64_t top = seen.top; !seen.empty() && top < seen.bottom; top += height)
    if (const Area area = take(x / step * step, top / step * step, width, height); !area.empty())
      return area;
  return {};
}

Area LabelLayout::place(const Area& box, int64_t width, int64_t height, int64_t step) {
  const Area seen = common_part(box, picture_);
  if (seen.empty()) return {};
  const int64_t x =
      std::max(std::min(seen.left, picture_.right - width), picture_.left) / step * step;
  const int64_t tops[] = {box.top - height,     seen.top,
                          box.bottom,           seen.bottom - height,
                          box.top - 2 * height, box.bottom + height,
                          box.top - 3 * height, box.bottom + 2 * height,
                          box.top - 4 * height, box.bottom + 3 * height};
  for (const int64_t top : tops)
    if (const Area area = take(x, top >= 0 ? top / step * step : top, width, height); !area.empty())
      return area;
  return {};
}

}  // namespace weir::draw
