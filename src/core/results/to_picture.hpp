// Moves objects from the coordinates of a model's input to those of the source picture.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/detection/candidate.hpp"
#include "core/results/answer.hpp"
#include "weir/source_map.hpp"

namespace weir::results {

// The object of a candidate in pixels of the model's input. The box of a candidate with an angle
// has its centre at the candidate's x, y.
Object object_of(const detection::Candidate& candidate, bool is_rotated) noexcept;

// Applies the map to boxes, rotations, key points and masks. Under a map that rotates, an upright
// box becomes the upright box around it, and its mask is turned and spans that box; unless
// `is_rotated`: then the box turns with the picture, and its mask with it.
void move_to_picture(const SourceMap& map, bool is_rotated, Answer* answer);

}  // namespace weir::results
