// Finds the tensors in a buffer from caps and headers.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/buffer/frame_parts.hpp"

#include <algorithm>
#include <string>

#include "core/tensor/tensor_header.hpp"
#include "gstcpp/buffer/frame_errors.hpp"

namespace weir::gst {
namespace {

size_t memory_size(GstBuffer* buffer, size_t index) {
  return gst_memory_get_sizes(gst_buffer_peek_memory(buffer, static_cast<guint>(index)), nullptr,
                              nullptr);
}

}  // namespace

void FrameParts::configure(const FrameSpec& spec) {
  spec_ = spec;
  parts_.clear();
  if (spec_.format != Format::Static) return;
  for (const auto& tensor : spec_.tensors)
    parts_.push_back({tensor, 0, static_cast<size_t>(tensor.bytes().value_or(0))});
}

Status FrameParts::read(GstBuffer* buffer) {
  if (spec_.format == Format::Static) return read_static(buffer);
  parts_.clear();
  return read_headers(buffer);
}

Status FrameParts::read_static(GstBuffer* buffer) {
  const size_t memories = gst_buffer_n_memory(buffer);
  const bool one_each = memories == std::min(parts_.size(), kMemoryLimit);
  const size_t alone = parts_.size() > kMemoryLimit ? kMemoryLimit - 1 : parts_.size();
  size_t offset = 0;
  for (size_t i = 0; i < parts_.size(); ++i) {
    if (one_each && i == alone) return read_packed(buffer);
    parts_[i].offset = offset;
    offset += parts_[i].size;
    if (one_each && memory_size(buffer, i) != parts_[i].size)
      return wrong_frame_size(
          spec_, std::to_string(memory_size(buffer, i)) + " bytes in memory " + std::to_string(i),
          "tensor " + std::to_string(i) + " (" + parts_[i].spec.to_string() + ") needs " +
              std::to_string(parts_[i].size) + " bytes");
  }
  if (!one_each && gst_buffer_get_size(buffer) < offset)
    return wrong_frame_size(spec_, buffer, "the buffer is too small");
  return ok();
}

Status FrameParts::read_packed(GstBuffer* buffer) {
  constexpr size_t kLast = kMemoryLimit - 1;
  const MappedMemory map(gst_buffer_peek_memory(buffer, kLast), GST_MAP_READ);
  if (!map) return memory_not_mapped();
  const auto ranges = read_packed_tensors(map.bytes(), Format::Static);
  if (!ranges) return ranges.error();
  if (ranges->size() != parts_.size() - kLast)
    return wrong_frame_size(spec_, std::to_string(kLast + ranges->size()) + " tensors",
                            "number of tensors");
  const size_t base = parts_[kLast - 1].offset + parts_[kLast - 1].size;
  for (size_t i = 0; i < ranges->size(); ++i) {
    FramePart& part = parts_[kLast + i];
    if ((*ranges)[i].size != part.size)
      return wrong_frame_size(spec_,
                              std::to_string((*ranges)[i].size) + " bytes in packed tensor " +
                                  std::to_string(kLast + i),
                              "tensor " + std::to_string(kLast + i));
    part.offset = base + (*ranges)[i].offset;
  }
  return ok();
}

Status FrameParts::add_chunk(std::span<const std::byte> chunk, size_t offset) {
  auto header = read_tensor_chunk(chunk);
  if (!header) return header.error();
  const auto payload = static_cast<size_t>(*header->payload_bytes());
  parts_.push_back({std::move(header->spec), offset, kTensorHeaderBytes + payload});
  return ok();
}

// Of a memory that holds several tensors.
Status FrameParts::add_chunks(std::span<const std::byte> memory, size_t offset, bool packed) {
  const auto ranges = packed ? read_packed_tensors(memory, spec_.format) : walk_chunks(memory);
  if (!ranges) return ranges.error();
  for (const auto& range : *ranges)
    if (auto s = add_chunk(memory.subspan(range.offset, range.size), offset + range.offset); !s)
      return s;
  return ok();
}

Status FrameParts::read_headers(GstBuffer* buffer) {
  const size_t memories = gst_buffer_n_memory(buffer);
  if (memories == 0) return buffer_is_empty();
  size_t base = 0;
  for (size_t i = 0; i < memories; ++i) {
    const MappedMemory map(gst_buffer_peek_memory(buffer, static_cast<guint>(i)), GST_MAP_READ);
    if (!map) return memory_not_mapped();
    const bool packed = i + 1 == kMemoryLimit && is_packed(map.bytes());
    const bool several = packed || memories == 1;
    if (auto s = several ? add_chunks(map.bytes(), base, packed) : add_chunk(map.bytes(), base); !s)
      return s;
    if (packed) return ok();
    base += map.bytes().size();
  }
  return ok();
}

}  // namespace weir::gst
