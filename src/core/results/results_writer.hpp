// Writes results as the tensors of a flexible stream, in the format of weir/results.h.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <functional>
#include <span>
#include <string>

#include "core/results/frame_results.hpp"

namespace weir::results {

// The weir-columns text of a stream with these features. Rows come first, then the tables that
// belong to them, then class-map and depth.
std::string make_columns(const Features& features);
// Number of tensors of a frame.
size_t tensor_count(const Features& features);
// The caps of the stream without a framerate. `source` is the name of the model.
std::string make_caps(const Features& features, const std::string& source);

// Returns writable memory of this many bytes for the next tensor.
using Reserve = std::function<std::span<std::byte>(size_t bytes)>;

// Writes each tensor with its 128-byte header. A frame without objects becomes one row of zeros,
// and one element of zeros in each of the tables. Throws what `reserve` throws.
void write(const FrameResults& results, const Features& features, const Reserve& reserve);

// Appends `part` with its tables to `all`. Masks of another size are resampled (nearest). Throws
// Failure (SPEC_MISMATCH) for a second class map or depth: a frame has one of each. `part` is left
// in an unspecified state.
void append(FrameResults* part, const Features& features, FrameResults* all);

}  // namespace weir::results
