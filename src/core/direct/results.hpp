// Results: the outputs of one invoke and their memory.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::direct {

class Results {
 public:
  Results() = default;
  // Copies names, since results may outlive their model.
  explicit Results(const std::vector<weir_tensor_info>& outputs);
  Results(Results&& other) noexcept;
  Results& operator=(Results&& other) noexcept;
  ~Results();

  // Allocates memory for each output of known size that has none.
  Status allocate(uint32_t alignment);
  // Sets memory lent by the caller for an output; it is not released.
  void lend(size_t index, void* data, uint64_t bytes) noexcept;
  // Call it after the invoke: INVOKE_FAILED unless each output has memory of the size of its shape.
  Status check() const;

  // Copies outputs that are not yet in the caller's memory, and describes them. FRAME_SIZE if an
  // output of open size has another size.
  Status copy_to(std::span<weir_tensor> into) const;

  std::vector<weir_tensor>& tensors() noexcept { return tensors_; }
  const std::vector<weir_tensor>& tensors() const noexcept { return tensors_; }

  // The number of frames in the invoke, which is the outermost extent of each output.
  uint32_t frames() const noexcept { return frames_; }
  void set_frames(uint32_t frames) noexcept { frames_ = frames; }
  // The part of an output for one frame, with an outermost extent of 1.
  weir_tensor of_frame(uint32_t frame, size_t index) const noexcept;

 private:
  void release() noexcept;
  std::vector<std::string> names_;
  std::vector<weir_tensor> tensors_;
  uint32_t frames_ = 1;
};

}  // namespace weir::direct
