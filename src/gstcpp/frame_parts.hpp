// FrameParts: where the tensors of a buffer lie, and buffers of some of them that share memory.
//
// Unlike FrameReader it maps nothing but headers: what only passes on is never looked at.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <span>
#include <vector>

#include "core/tensor/packed_tensors.hpp"
#include "gstcpp/frame_pool.hpp"
#include "gstcpp/ref.hpp"

namespace weir::gst {

struct FramePart {
  TensorSpec spec;              // from caps, or from the header when flexible
  size_t offset = 0, size = 0;  // in the buffer; with the header when flexible
};

class FrameParts {
 public:
  // What the buffers to come hold.
  void configure(const FrameSpec& spec);
  // Checks sizes and headers; more than 16 tensors are found in the packed last memory.
  Status read(GstBuffer* buffer);
  const std::vector<FramePart>& parts() const noexcept { return parts_; }
  const FrameSpec& spec() const noexcept { return spec_; }

 private:
  Status read_static(GstBuffer* buffer);
  Status read_packed(GstBuffer* buffer);
  Status read_headers(GstBuffer* buffer);
  Status add_chunk(std::span<const std::byte> chunk, size_t offset);

  FrameSpec spec_;
  std::vector<FramePart> parts_;
};

// The bytes of `buffer` as one memory: the buffer's own, or a part of one, by reference. Copied,
// and counted in `copied`, when they lie in several or their memory may not be shared.
// Errors: MAP_FAILED, OUT_OF_MEMORY.
Result<Ref<GstMemory>> share_bytes(GstBuffer* buffer, size_t offset, size_t size, uint64_t* copied);

// A buffer of the tensors that `chosen` names (indices below parts.parts().size()), with the
// metadata of `in`. From the 16th tensor of it on they are copied into a packed memory.
Result<Ref<GstBuffer>> pick_tensors(GstBuffer* in, const FrameParts& parts,
                                    std::span<const size_t> chosen, uint64_t* copied);
// The same as a frame of `pool`: for static tensors that must get headers.
Result<Ref<GstBuffer>> copy_tensors(GstBuffer* in, const FrameParts& parts,
                                    std::span<const size_t> chosen, FramePool* pool,
                                    uint64_t* copied);

// An empty buffer with time-stamps, flags and metas of `in`, for memories of it (sharing_buffer()).
Ref<GstBuffer> buffer_like(GstBuffer* in);

}  // namespace weir::gst
