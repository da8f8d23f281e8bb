// The placeholder tensor in caps of streams whose tensors are known only from the first frame.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>

#include "core/tensor/frame_spec.hpp"

namespace weir {

inline TensorSpec placeholder() {
  return {ElementType::UInt8, Shape{1}, ""};
}

// Whether other caps may follow before the first frame. Only the size decides, because elements in
// between may have changed the type.
inline bool may_be_placeholder(const FrameSpec& spec) {
  const auto is_one_element = [](const TensorSpec& tensor) { return tensor.shape.count() == 1; };
  return spec.format == Format::Static &&
         std::all_of(spec.tensors.begin(), spec.tensors.end(), is_one_element);
}

}  // namespace weir
