// Converts the C structs to core's values and back.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <glib.h>

#include "core/tensor/frame_spec.hpp"
#include "tensor_typedef.h"

namespace weir::compat {

inline ElementType element_type(int type) noexcept {
  return type >= 0 && type < _NNS_END ? static_cast<ElementType>(type) : ElementType::End;
}
inline Shape to_shape(const tensor_dim dim) noexcept {
  return Shape(std::span<const uint32_t>(dim, NNS_TENSOR_RANK_LIMIT));
}
// Parses like Shape::parse(), but uses the leading digits of each part: "5U" is 5.
Shape parse_shape(std::string_view text);
// Writes the first `rank` dimensions, extended with ":1" if `padding`; all of them for a rank of 0
// or above 16.
std::string rank_text(const Shape& shape, unsigned rank, bool padding);
TensorSpec to_spec(const GstTensorInfo& info);
// Overwrites `info`.
void write(const TensorSpec& spec, GstTensorInfo* info);

// Returns tensor `index` < NNS_TENSOR_SIZE_LIMIT; null if `extra` is missing.
const GstTensorInfo* tensor_at(const GstTensorsInfo& info, size_t index) noexcept;
GstTensorInfo* tensor_at(GstTensorsInfo& info, size_t index) noexcept;
// Does the same, and allocates `extra` if necessary.
GstTensorInfo* room_at(GstTensorsInfo& info, size_t index) noexcept;

// Returns false, with a log line, when there are too many tensors.
bool can_be(const char* function, const GstTensorsInfo& info) noexcept;
// Reads at most the allowed number of tensors; those without an entry are invalid.
FrameSpec to_spec(const GstTensorsInfo& info);
FrameSpec to_spec(const GstTensorsConfig& config);
// Overwrites `info`.
void write(const FrameSpec& spec, GstTensorsInfo* info);
void write(const FrameSpec& spec, GstTensorsConfig* config);

// Makes a copy for C; free it with g_free().
inline gchar* text(const std::string& from) {
  return g_strndup(from.data(), from.size());
}

}  // namespace weir::compat
