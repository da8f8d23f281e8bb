// LabelLayout: places labels so that they do not cover each other.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <vector>

#include "core/draw/canvas.hpp"

namespace weir::draw {

// Labels are placed one after the other, the most important first. Each gets the first free one of:
// above its box, inside it at the top, below it, inside at the bottom, then above and below again,
// shifted away from the box by whole labels, up to three of them. Where no place is free, the label
// is not placed: a label of less importance never covers one of more.
class LabelLayout {
 public:
  // `picture`: labels stay inside; one that is larger begins at its left or upper edge.
  explicit LabelLayout(const Area& picture) : picture_(picture) {}

  // Returns the place of a label of this size; an empty area where none is free. `step`: places are
  // multiples of it (2 where pixels share chroma).
  Area place(const Area& box, int64_t width, int64_t height, int64_t step);
  // The same for labels that are written one below the other inside `box`, from its top on.
  Area place_in_list(const Area& box, int64_t width, int64_t height, int64_t step);

 private:
  Area take(int64_t x, int64_t top, int64_t width, int64_t height);
  bool is_free(const Area& area) const;

  Area picture_;
  std::vector<Area> taken_;
};

}  // namespace weir::draw
