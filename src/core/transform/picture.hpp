// What a transform does to the way back into the picture.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/transform/transform.hpp"
#include "weir/picture_map.hpp"

namespace weir::transform {

// The map of the output of `operation`: transpositions move the dimensions of x and y, a padding
// moves the picture within the tensor. Other operations leave it.
PictureMap moved(const Operation& operation, const PictureMap& in) noexcept;

}  // namespace weir::transform
