// FrameParts: where the tensors of a buffer are, and buffers of some of them that share memory.
//
// Unlike FrameReader it maps only headers: payloads that pass through are never mapped.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <span>
#include <vector>

#include "core/tensor/packed_tensors.hpp"
#include "gstcpp/buffer/frame_pool.hpp"
#include "gstcpp/element/ref.hpp"

namespace weir::gst {

struct FramePart {
  TensorSpec spec;              // from caps, or from the header when flexible
  size_t offset = 0, size = 0;  // in the buffer; includes the header when flexible
};

class FrameParts {
 public:
  // Sets what the following buffers hold.
  void configure(const FrameSpec& spec);
  // Checks sizes and headers; finds more than 16 tensors in the packed last memory.
  Status read(GstBuffer* buffer);
  const std::vector<FramePart>& parts() const noexcept { return parts_; }
  const FrameSpec& spec() const noexcept { return spec_; }

 private:
  Status read_static(GstBuffer* buffer);
  Status read_packed(GstBuffer* buffer);
  Status read_headers(GstBuffer* buffer);
  Status add_chunk(std::span<const std::byte> chunk, size_t offset);
  Status add_chunks(std::span<const std::byte> memory, size_t offset, bool packed);

  FrameSpec spec_;
  std::vector<FramePart> parts_;
};

// Returns the bytes of `buffer` as one memory: the buffer's own or a part of it, by reference.
// Copies, and counts it in `copied`, when they span several memories or the memory cannot be
// shared.
// Errors: MAPPING_FAILED, OUT_OF_MEMORY.
Result<Ref<GstMemory>> share_bytes(GstBuffer* buffer, size_t offset, size_t size, uint64_t* copied);

// Makes a buffer of the `chosen` tensors (indices into parts.parts()) with the metadata of `in`.
// The 16th and later ones are copied into a packed memory when there are more than 16.
Result<Ref<GstBuffer>> pick_tensors(GstBuffer* in, const FrameParts& parts,
                                    std::span<const size_t> chosen, uint64_t* copied);
// The same as a frame of `pool`: for static tensors that need headers.
Result<Ref<GstBuffer>> copy_tensors(GstBuffer* in, const FrameParts& parts,
                                    std::span<const size_t> chosen, FramePool* pool,
                                    uint64_t* copied);

// Makes an empty buffer with the timestamps, flags and metas of `in`, for its memories
// (sharing_buffer()).
Ref<GstBuffer> buffer_like(GstBuffer* in);

}  // namespace weir::gst
