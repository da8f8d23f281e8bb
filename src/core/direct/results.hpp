// Results: the outputs of one invoke, with the memory that they lie in.
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
  // Names are copied: results may outlive their model.
  explicit Results(const std::vector<weir_tensor_info>& outputs);
  Results(Results&& other) noexcept;
  Results& operator=(Results&& other) noexcept;
  ~Results();

  // Memory of the results' own for each output whose size is known and that has none yet.
  Status allocate(uint32_t alignment);
  // Memory that the caller lends for an output. Not released.
  void lend(size_t index, void* data, uint64_t bytes) noexcept;
  // After the invoke: each output has memory of the size of its shape. INVOKE_FAILED otherwise.
  Status check() const;

  // Into the caller's memory, where it does not lie there yet; describes it. FRAME_SIZE when an
  // output of open size has another one.
  Status copy_to(std::span<weir_tensor> into) const;

  std::vector<weir_tensor>& tensors() noexcept { return tensors_; }
  const std::vector<weir_tensor>& tensors() const noexcept { return tensors_; }

  // Frames that were invoked at once; each output's outermost axis counts them.
  uint32_t frames() const noexcept { return frames_; }
  void set_frames(uint32_t frames) noexcept { frames_ = frames; }
  // The part of an output that belongs to one frame, its outermost extent 1.
  weir_tensor of_frame(uint32_t frame, size_t index) const noexcept;

 private:
  void release() noexcept;
  std::vector<std::string> names_;
  std::vector<weir_tensor> tensors_;
  uint32_t frames_ = 1;
};

}  // namespace weir::direct
