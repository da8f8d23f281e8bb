// Placement: which part of a picture fills which part of a tensor, and the source map back.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/preprocess/axis.hpp"
#include "core/preprocess/preparation.hpp"
#include "core/preprocess/rotated_part.hpp"
#include "weir/source_map.hpp"

namespace weir::preprocess {

struct Placement {
  Rect source;   // in the picture
  Rect content;  // in the tensor; padding surrounds it
  // For a region: the complete mapping onto the tensor, of which `source` and `content` are the
  // parts within the picture. Their sides are 0 if the centre of no target pixel is in the picture.
  std::optional<AxisWhole> columns = std::nullopt, rows = std::nullopt;
  // For a rotated region: `content` is where all of it is, and `source` the picture.
  std::optional<RotatedPart> rotated = std::nullopt;
};

// Precondition: check(preparation). Parts are whole pixels: letterboxed content is rounded to the
// nearest size. It and a centred crop start at most half a pixel left of and above the exact
// centre.
Placement place(const Preparation& preparation) noexcept;
// The same, for `region` of `picture` instead of the preparation's own.
Placement place(const Preparation& preparation, const Rect& picture, const Roi& region) noexcept;

// OPTION_VALUE if the region shows no part of the picture.
Status check_region(const Preparation& preparation, const Rect& picture, const Roi& region);

// Maps tensor coordinates to coordinates of the source picture.
SourceMap make_source_map(const Preparation& preparation) noexcept;

}  // namespace weir::preprocess
