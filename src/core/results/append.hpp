// Joins the answers of several pictures, such as the regions of a frame.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/results/answer.hpp"

namespace weir::results {

// Appends `part` with its tables to `all`. Masks of another size are resampled (nearest). Throws
// Failure (SPEC_MISMATCH) for a second class map or depth: a frame has one of each. `part` is left
// in an unspecified state.
void append(Answer* part, const Features& features, Answer* all);

}  // namespace weir::results
