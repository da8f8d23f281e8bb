// FrameLayout: where the tensors of a frame lie in a GstBuffer, whose sizes and headers it checks.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <span>
#include <vector>

#include "core/tensor/frame_spec.hpp"
#include "gstcpp/element/ref.hpp"

namespace weir::gst {

struct TensorPlace {
  TensorSpec spec;              // of this frame: from caps, or from the header when flexible
  size_t offset = 0, size = 0;  // in the buffer; with the header
  int memory = -1;              // index of the memory that holds only this tensor, or -1
  size_t header_bytes = 0;      // 128 in flexible and sparse streams
  uint32_t nonzero_count = 0;
  Format format = Format::Static;  // from its header; flexible headers may give any format
  std::span<std::byte> payload;    // after read(): without the header
  size_t capacity = 0;             // readable bytes from payload.data() on
};

// Reads one buffer at a time and reuses its vectors, so that only the first frame allocates.
// Static: the memories must have the sizes of the spec; a different number of memories is split by
// the computed sizes. Flexible and sparse: headers are read and checked. More than 16 tensors are
// found in the packed last memory.
class FrameLayout {
 public:
  // Finds the tensors without mapping payloads of static streams. Errors: FRAME_SIZE,
  // HEADER_INVALID, MAPPING_FAILED.
  Status locate(GstBuffer* buffer, const FrameSpec& spec);
  // The same, and maps the payloads until the next call, or until clear(). Merges memories if
  // tensors and memories differ; for writing, the merged memory replaces those of the buffer.
  // FORMAT_UNSUPPORTED: a tensor of a flexible stream is sparse. After an error nothing is mapped.
  Status read(GstBuffer* buffer, const FrameSpec& spec, GstMapFlags flags = GST_MAP_READ);
  void clear() noexcept;
  const std::vector<TensorPlace>& tensors() const noexcept { return places_; }
  // Whether a tensor has no elements. Only in flexible streams.
  bool has_empty_tensor() const noexcept;
  uint64_t bytes_copied() const noexcept { return copied_; }  // by merging, in the last read()

 private:
  Status find(GstBuffer* buffer, const FrameSpec& spec, GstMapFlags flags);
  Status find_static(GstBuffer* buffer, const FrameSpec& spec);
  Status find_packed(GstBuffer* buffer, const FrameSpec& spec, size_t offset);
  Status find_headers(GstBuffer* buffer, const FrameSpec& spec, GstMapFlags flags);
  Status add_chunk(std::span<const std::byte> chunk, size_t offset, int memory);
  Status add_chunks(std::span<const std::byte> memory, size_t offset, bool packed, Format format);
  Status check_dense() const;
  Status map_next(GstBuffer* buffer, GstMapFlags flags);
  Status map_merged(GstBuffer* buffer, GstMapFlags flags);
  Status map_all(GstBuffer* buffer, GstMapFlags flags);
  Status map_payloads(GstBuffer* buffer, GstMapFlags flags);
  void unmap() noexcept;

  bool is_split_ = false;           // static tensors do not match the memories
  Ref<GstMemory> whole_;            // merged memory of split tensors; outlives maps_
  std::vector<MappedMemory> maps_;  // of the first memories
  std::vector<TensorPlace> places_;
  uint64_t copied_ = 0;
};

// Whether a tensor of this frame of a flexible stream has no elements. False for a frame that
// FrameLayout rejects.
bool has_empty_tensor(GstBuffer* buffer);

}  // namespace weir::gst
