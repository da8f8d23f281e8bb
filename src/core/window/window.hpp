// Windows over the frames of a stream: which frames each output holds, and where their bytes go.
//
// A buffer holds `in` frames of equal size; window k holds the frames [k * step, k * step + out).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/tensor/frame_spec.hpp"

namespace weir::window {

struct WindowRequest {
  uint32_t frames_in = 1, frames_out = 1;  // at least 1
  uint32_t frames_flush = 0;               // frames from one window to the next; 0 = frames_out
  uint32_t dimension = 15;                 // along which frames are counted and concatenated
  bool concatenate = true;  // along that dimension; false: frames one after the other
};

// How the frames of one tensor are laid out in a window: blocks of block_bytes of each frame in
// turn. block_bytes == frame_bytes if whole frames follow each other.
struct WindowLayout {
  size_t frame_bytes = 0;
  size_t block_bytes = 0;
  bool is_plain() const noexcept { return block_bytes == frame_bytes; }
};

struct WindowPlan {
  uint64_t in = 1, out = 1, step = 1;  // frames
  bool passes_through = false;         // each buffer is a window
  std::vector<TensorSpec> output;      // as written in caps
  std::vector<TensorSpec> memory;     // with the real size of windows: `output` unless size_differs
  std::vector<WindowLayout> layouts;  // one for each tensor
  // `dimension` exceeds the rank of these tensors, so caps cannot express the number of frames.
  bool size_differs = false;

  bool overlaps() const noexcept { return step < out; }
  uint64_t begin(uint64_t window) const noexcept { return window * step; }
  // The most buffers that follow the one with a window's first frame until its last frame has
  // arrived.
  uint64_t buffers_waited() const noexcept;
};

// OPTION_VALUE if the dimension is not a multiple of frames_in, frames_flush cannot be reached
// ("cannot flush"), or a tensor cannot be cut; LIMIT_EXCEEDED if the output is too large.
Result<WindowPlan> plan(const WindowRequest& request, const std::vector<TensorSpec>& input);

// Copies frame `index` of `frames` of a window to its place in `out`.
void place(const WindowLayout& layout, uint64_t index, uint64_t frames,
           std::span<const std::byte> frame, std::span<std::byte> out) noexcept;

// The duration in nanoseconds of `frames` frames at `rate`, rounded down once. 0 if the rate is
// unknown or 0.
uint64_t to_time(uint64_t frames, const Fraction& rate) noexcept;

}  // namespace weir::window
