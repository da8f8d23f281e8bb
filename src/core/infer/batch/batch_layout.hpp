// The layout of a batch: where each frame is within its tensors.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstring>
#include <span>

#include "core/tensor/element_type.hpp"
#include "weir/abi.h"

namespace weir::infer {

// Frame `slot` of a batch of `slots` frames has `parts` parts of `part_bytes` bytes; part p begins
// at (p * slots + slot) * part_bytes. There is one part if the batch axis is the outermost.
struct BatchLayout {
  size_t parts = 1;
  size_t part_bytes = 0;

  // `frame`: the tensor of one frame, with all extents known.
  static BatchLayout of(const weir_tensor_info& frame, uint32_t axis) noexcept {
    BatchLayout out;
    out.part_bytes = size_of(static_cast<ElementType>(frame.type));
    for (uint32_t i = 0; i < frame.rank; ++i)
      (i < axis ? out.parts : out.part_bytes) *= static_cast<size_t>(frame.shape[i]);
    return out;
  }
  size_t frame_bytes() const noexcept { return parts * part_bytes; }
  bool in_one_piece() const noexcept { return parts == 1; }

  void put(std::span<const std::byte> frame, size_t slot, size_t slots, std::byte* batch) const {
    for (size_t p = 0; p < parts; ++p)
      std::memcpy(batch + (p * slots + slot) * part_bytes, frame.data() + p * part_bytes,
                  part_bytes);
  }
  void get(const std::byte* batch, size_t slot, size_t slots, std::span<std::byte> frame) const {
    for (size_t p = 0; p < parts; ++p)
      std::memcpy(frame.data() + p * part_bytes, batch + (p * slots + slot) * part_bytes,
                  part_bytes);
  }
};

}  // namespace weir::infer
