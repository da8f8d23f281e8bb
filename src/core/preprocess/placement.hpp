// Placement: which part of a picture goes to which part of a tensor, and the way back.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/preprocess/axis.hpp"
#include "core/preprocess/preparation.hpp"
#include "weir/picture_map.hpp"

namespace weir::preprocess {

struct Placement {
  Rect source;   // in the picture
  Rect content;  // in the tensor; what is around it is padding
  // Of a region: what is laid on the tensor, of which `source` and `content` are the parts within
  // the picture. Sides of 0 where no target pixel's middle lies in the picture.
  std::optional<AxisWhole> columns = std::nullopt, rows = std::nullopt;
};

// Precondition: check(preparation). Parts are whole pixels: letterboxed content is rounded to the
// nearest size and, as a centred crop, lies at most half a pixel left of and above the middle.
Placement place(const Preparation& preparation) noexcept;
// The same for this region of `picture` instead of the preparation's own.
Placement place(const Preparation& preparation, const Rect& picture, const Box& region) noexcept;

// OPTION_VALUE where that shows nothing of the picture.
Status check_region(const Preparation& preparation, const Rect& picture, const Box& region);

// From the tensor back to the picture.
PictureMap way_back(const Preparation& preparation) noexcept;

}  // namespace weir::preprocess
