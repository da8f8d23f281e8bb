// Placement: which part of a picture goes to which part of a tensor, and the way back.
#pragma once
#include "core/preprocess/preparation.hpp"
#include "weir/picture_map.hpp"

namespace weir::preprocess {

struct Placement {
  Rect source;   // in the picture
  Rect content;  // in the tensor; what is around it is padding
};

// Precondition: check(preparation). Parts are whole pixels: letterboxed content is rounded to the
// nearest size and, as a centred crop, lies at most half a pixel left of and above the middle.
Placement place(const Preparation& preparation) noexcept;

// From the tensor back to the picture.
PictureMap way_back(const Preparation& preparation) noexcept;

}  // namespace weir::preprocess
