// Helpers that find a head's tensors among the outputs of a model.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <optional>
#include <string_view>

#include "core/heads/head.hpp"
#include "core/tensor/geometry.hpp"

namespace weir::heads {

// The rows of an output COLUMNS:ROWS; a matrix of one column may also be written ROWS. 0 if the
// output has another shape.
size_t matrix_rows(const OutputSignature& output, size_t columns) noexcept;
// Number of elements; 0 if it is not known.
size_t element_count(const OutputSignature& output) noexcept;
// Whether an output's name contains `part`, in any case.
bool has_name_with(const OutputSignature& output, std::string_view part);
bool any_name_has(const ModelSignature& model, std::string_view part);

// Whether the only output has three numbers for each pixel of the input, or of the input enlarged,
// as pictures have that a network made brighter or larger. Without labels nothing tells them from
// scores of three classes.
bool looks_like_picture(const ModelSignature& model) noexcept;
// The error for it. `fix` names the head of scores.
Error picture_instead_of_results(const ModelSignature& model, std::string fix);

// Throws Failure (SPEC_MISMATCH) if the size of the model's input is not known.
void need_input_size(Size input);

// A probability from a value that may be anything: 0 for NaN.
float to_probability(float value) noexcept;

}  // namespace weir::heads
