// WindowStrip: the consecutive frames of one tensor, so that overlapping windows are parts of the
// same memory and each byte is copied once.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <functional>
#include <span>

#include "elements/tensor_aggregator/shared_blocks.hpp"

namespace weir {

class WindowStrip {
 public:
  WindowStrip() = default;
  // `frame_bytes` per frame, `frames` per window.
  WindowStrip(size_t frame_bytes, uint64_t frames);

  // Returns the window that begins at frame `begin`; windows begin in ascending order. `frame`
  // reads frames that the strip does not have, and their bytes are added to `copied`.
  using ReadFrame = std::function<std::span<const std::byte>(uint64_t)>;
  GstMemory* window(uint64_t begin, const ReadFrame& frame, uint64_t* copied);
  void clear() noexcept { block_.reset(); }

 private:
  size_t frame_bytes_ = 0;
  uint64_t frames_ = 0;
  uint64_t capacity_ = 0;  // frames
  std::shared_ptr<BlockPool> pool_;
  std::shared_ptr<std::byte> block_;
  uint64_t begin_ = 0, end_ = 0;  // the range of frames in the block
};

}  // namespace weir
