// FrameReader: the tensors of one buffer, mapped and checked against its caps.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <span>
#include <vector>

#include "core/tensor/packed_tensors.hpp"
#include "core/tensor/tensor_header.hpp"
#include "gstcpp/element/ref.hpp"

namespace weir::gst {

struct TensorView {
  TensorSpec spec;               // of this frame: from caps, or from the header when flexible
  std::span<std::byte> payload;  // without the header
  size_t capacity = 0;           // readable bytes from payload.data() on
  int memory = -1;               // index of the memory that holds only this tensor, or -1
  size_t header_bytes = 0;       // 128 in flexible and sparse streams
  uint32_t nonzero_count = 0;
  Format format = Format::Static;  // from its header; flexible headers may give any format
};

// Reads one buffer at a time and reuses its vectors, so that only the first frame allocates. The
// views are valid until the next read() or clear(), which unmap; so does a read() that fails.
class FrameReader {
 public:
  // Static: the memories must have the sizes of the spec; a different number of memories is
  // re-split by the computed sizes. Flexible and sparse: headers are read and checked. More than 16
  // tensors are found in the packed last memory.
  // FORMAT_UNSUPPORTED: a tensor of a flexible stream is sparse.
  Status read(GstBuffer* buffer, const FrameSpec& spec, GstMapFlags flags = GST_MAP_READ);
  void clear() noexcept;
  const std::vector<TensorView>& tensors() const noexcept { return views_; }
  uint64_t bytes_copied() const noexcept { return copied_; }  // by merging, in the last read()

 private:
  Status map(GstBuffer* buffer, GstMapFlags flags);
  Status read_static(GstBuffer* buffer, const FrameSpec& spec, GstMapFlags flags);
  Status split_by_size(GstBuffer* buffer, const FrameSpec& spec, GstMapFlags flags);
  Status read_headers(GstBuffer* buffer, const FrameSpec& spec, GstMapFlags flags);
  Status read_single_memory();
  Status check_dense() const;
  Status add_chunk(std::span<std::byte> chunk, size_t capacity, int memory);
  Status add_chunks(const std::vector<ByteRange>& ranges, const MappedMemory& memory);
  void add_static(size_t index, const FrameSpec& spec, std::span<std::byte> bytes, size_t capacity,
                  int memory);

  Ref<GstMemory> whole_;  // merged memory when memories and tensors differ; outlives maps_
  std::vector<MappedMemory> maps_;
  std::vector<TensorView> views_;
  uint64_t copied_ = 0;
};

}  // namespace weir::gst
