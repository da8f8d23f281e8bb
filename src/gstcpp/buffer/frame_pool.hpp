// FramePool: output buffers of one stream. Bounds what it retains, never blocks and counts its
// allocations.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <span>
#include <vector>

#include "core/limit/buffer_limit.hpp"
#include "core/tensor/frame_spec.hpp"
#include "gstcpp/buffer/allocation.hpp"
#include "gstcpp/element/ref.hpp"

namespace weir::gst {

struct FramePoolStats {
  uint64_t allocated = 0;  // buffers allocated since the pool was made
  uint64_t retained = 0;   // free buffers
};

// A dense buffer: one memory per tensor; from the 17th tensor on, the last memory is packed. A
// Writer rewrites the headers for each frame because the last user may have changed them.
class FramePool {
 public:
  // Sizes must be known (specs valid). In a static stream each tensor follows the alignment and
  // padding of `allocation`; headers shift it by 128 bytes.
  static Result<FramePool> make(std::vector<TensorSpec> tensors, Format format,
                                MediaType media = MediaType::Tensor, Allocation allocation = {},
                                size_t retain = 8);
  FramePool() = default;

  // Returns a buffer to write into. One with a single memory may be shortened; the pool restores
  // its length.
  // Errors: OUT_OF_MEMORY.
  Result<Ref<GstBuffer>> acquire();
  // The same. LIMIT_EXCEEDED when the pool's buffers are larger than the limit.
  Result<Ref<GstBuffer>> acquire(const BufferLimit& limit);
  // Maps a buffer of this pool for writing: one span per tensor, valid until unmap().
  class Writer {
   public:
    // `format`: written into the headers, if the stream has any
    // (docs/compatibility/types-and-caps.md 1.6).
    Status map(const FramePool& pool, GstBuffer* buffer, Format format = Format::Static);
    void unmap() noexcept { maps_.clear(), payloads_.clear(); }
    const std::vector<std::span<std::byte>>& payloads() const noexcept { return payloads_; }

   private:
    std::vector<MappedMemory> maps_;
    std::vector<std::span<std::byte>> payloads_;
  };

  FramePoolStats stats() const;
  const std::vector<TensorSpec>& tensors() const noexcept { return tensors_; }
  explicit operator bool() const noexcept { return static_cast<bool>(pool_); }

 private:
  std::vector<TensorSpec> tensors_;
  size_t header_bytes_ = 0;
  MediaType media_ = MediaType::Tensor;
  Ref<GstBufferPool> pool_;
};

}  // namespace weir::gst
