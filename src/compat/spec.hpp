// The C structs and the core's values, one into the other.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <glib.h>

#include "core/tensor/frame_spec.hpp"
#include "tensor_typedef.h"

namespace weir::compat {

inline ElementType element_type(int type) noexcept {
  return type >= 0 && type < _NNS_END ? static_cast<ElementType>(type) : ElementType::End;
}
inline Shape shape_of(const tensor_dim dim) noexcept {
  return Shape(std::span<const uint32_t>(dim, NNS_TENSOR_RANK_LIMIT));
}
// As Shape::parse(), and of a part that begins with a number the number is read: "5U" is 5.
Shape parse_shape(std::string_view text);
// The first `rank` dimensions, with ":1" for missing ones where `padding`; all of them for a rank
// of 0 or beyond 16.
std::string rank_text(const Shape& shape, unsigned rank, bool padding);
TensorSpec spec_of(const GstTensorInfo& info);
// `info` is written over.
void write(const TensorSpec& spec, GstTensorInfo* info);

// Tensor `index` < NNS_TENSOR_SIZE_LIMIT; null where `extra` is not there.
const GstTensorInfo* tensor_at(const GstTensorsInfo& info, size_t index) noexcept;
GstTensorInfo* tensor_at(GstTensorsInfo& info, size_t index) noexcept;
// The same, with `extra` made where it is needed.
GstTensorInfo* room_at(GstTensorsInfo& info, size_t index) noexcept;

// False, with a line in the log, for more tensors than there can be.
bool can_be(const char* function, const GstTensorsInfo& info) noexcept;
// As many tensors as there can be; those without an entry are not valid.
FrameSpec spec_of(const GstTensorsInfo& info);
FrameSpec spec_of(const GstTensorsConfig& config);
// They are written over.
void write(const FrameSpec& spec, GstTensorsInfo* info);
void write(const FrameSpec& spec, GstTensorsConfig* config);

// A copy for C: g_free().
inline gchar* text(const std::string& from) {
  return g_strndup(from.data(), from.size());
}

}  // namespace weir::compat
