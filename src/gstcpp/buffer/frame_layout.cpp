// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/buffer/frame_layout.hpp"

#include <algorithm>
#include <string>

#include "core/tensor/packed_tensors.hpp"
#include "core/tensor/tensor_header.hpp"
#include "gstcpp/buffer/deferred_memory.hpp"
#include "gstcpp/buffer/frame_errors.hpp"
#include "gstcpp/buffer/memory_part.hpp"

namespace weir::gst {
namespace {

size_t size_of_memory(GstBuffer* buffer, size_t index) {
  return gst_memory_get_sizes(gst_buffer_peek_memory(buffer, static_cast<guint>(index)), nullptr,
                              nullptr);
}

}  // namespace

void FrameLayout::unmap() noexcept {
  maps_.clear();
  whole_ = {};
}

void FrameLayout::clear() noexcept {
  places_.clear();
  unmap();
}

bool FrameLayout::has_empty_tensor() const noexcept {
  return std::any_of(places_.begin(), places_.end(),
                     [](const TensorPlace& place) { return place.spec.shape.is_empty(); });
}

Status FrameLayout::locate(GstBuffer* buffer, const FrameSpec& spec) {
  Status status = find(buffer, spec, GST_MAP_READ);
  unmap();
  return status;
}

Status FrameLayout::read(GstBuffer* buffer, const FrameSpec& spec, GstMapFlags flags) {
  Status status = find(buffer, spec, flags);
  if (status && spec.format == Format::Flexible) status = check_dense();
  if (status) status = map_payloads(buffer, flags);
  if (!status) clear();  // memory must not be mapped when the caller releases the buffer
  return status;
}

Status FrameLayout::find(GstBuffer* buffer, const FrameSpec& spec, GstMapFlags flags) {
  unmap();
  copied_ = 0;
  is_split_ = false;
  return spec.format == Format::Static ? find_static(buffer, spec)
                                       : find_headers(buffer, spec, flags);
}

// Callers read as many bytes as the dimensions give; a sparse payload is shorter.
Status FrameLayout::check_dense() const {
  for (size_t i = 0; i < places_.size(); ++i)
    if (places_[i].format == Format::Sparse)
      return Error{.code = Code::FORMAT_UNSUPPORTED,
                   .what = "a tensor of a flexible stream is sparse",
                   .offered = places_[i].spec.to_string(),
                   .needed = "dense tensors",
                   .difference = "tensor " + std::to_string(i),
                   .fix = "other/tensors,format=sparse ! tensor_sparse_dec"};
  return ok();
}

Status FrameLayout::find_static(GstBuffer* buffer, const FrameSpec& spec) {
  const size_t count = spec.tensors.size();
  const size_t alone = count > kMemoryLimit ? kMemoryLimit - 1 : count;
  is_split_ = gst_buffer_n_memory(buffer) != std::min(count, kMemoryLimit);
  if (is_split_ && gst_buffer_get_size(buffer) < spec.bytes().value_or(UINT64_MAX))
    return wrong_frame_size(spec, buffer, "the buffer is too small");
  places_.resize(count);
  size_t offset = 0;
  for (size_t i = 0; i < count; ++i) {
    const auto bytes = spec.tensors[i].bytes();
    TensorPlace& place = places_[i];
    place.spec = spec.tensors[i];  // keeps the memory of its name
    place.offset = offset;
    place.size = static_cast<size_t>(bytes.value_or(0));
    place.memory = is_split_ || i >= alone ? -1 : static_cast<int>(i);
    place.header_bytes = place.nonzero_count = 0;
    place.format = Format::Static;
    offset += place.size;
    if (place.memory >= 0 && size_of_memory(buffer, i) != bytes)
      return wrong_frame_size(
          spec, std::to_string(size_of_memory(buffer, i)) + " bytes in memory " + std::to_string(i),
          "tensor " + std::to_string(i) + " (" + place.spec.to_string() + ") needs " +
              std::to_string(place.size) + " bytes");
  }
  return is_split_ || alone == count ? ok() : find_packed(buffer, spec, places_[alone].offset);
}

// Of the memory at `offset`, which holds the tensors from the 16th on.
Status FrameLayout::find_packed(GstBuffer* buffer, const FrameSpec& spec, size_t offset) {
  constexpr size_t kLast = kMemoryLimit - 1;
  const MappedMemory last(gst_buffer_peek_memory(buffer, kLast), GST_MAP_READ);
  if (!last) return memory_not_mapped();
  const auto ranges = read_packed_tensors(last.bytes(), Format::Static);
  if (!ranges) return ranges.error();
  if (ranges->size() != places_.size() - kLast)
    return wrong_frame_size(spec, std::to_string(kLast + ranges->size()) + " tensors",
                            "number of tensors");
  for (size_t i = 0; i < ranges->size(); ++i) {
    TensorPlace& place = places_[kLast + i];
    if ((*ranges)[i].size != place.spec.bytes())
      return wrong_frame_size(spec,
                              std::to_string((*ranges)[i].size) + " bytes in packed tensor " +
                                  std::to_string(kLast + i),
                              "tensor " + std::to_string(kLast + i));
    place.offset = offset + (*ranges)[i].offset;
  }
  return ok();
}

Status FrameLayout::find_headers(GstBuffer* buffer, const FrameSpec& spec, GstMapFlags flags) {
  places_.clear();
  const size_t memories = gst_buffer_n_memory(buffer);
  if (memories == 0) return buffer_is_empty();
  size_t offset = 0;
  for (size_t i = 0; i < memories; ++i) {
    if (auto status = map_next(buffer, flags); !status) return status;
    const std::span<const std::byte> bytes = maps_[i].bytes();
    const bool packed = i + 1 == kMemoryLimit && is_packed(bytes);
    Status status = packed || memories == 1 ? add_chunks(bytes, offset, packed, spec.format)
                                            : add_chunk(bytes, offset, static_cast<int>(i));
    if (!status) return status;
    offset += bytes.size();
  }
  return ok();
}

// Of a memory that may hold several tensors.
Status FrameLayout::add_chunks(std::span<const std::byte> memory, size_t offset, bool packed,
                               Format format) {
  const auto ranges = packed ? read_packed_tensors(memory, format) : walk_chunks(memory);
  if (!ranges) return ranges.error();
  for (const auto& range : *ranges)
    if (auto status = add_chunk(memory.subspan(range.offset, range.size), offset + range.offset,
                                ranges->size() == 1 ? 0 : -1);
        !status)
      return status;
  return ok();
}

Status FrameLayout::add_chunk(std::span<const std::byte> chunk, size_t offset, int memory) {
  auto header = read_tensor_chunk(chunk);
  if (!header) return header.error();
  const auto payload = static_cast<size_t>(*header->payload_bytes());
  places_.push_back({.spec = std::move(header->spec),
                     .offset = offset,
                     .size = kTensorHeaderBytes + payload,
                     .memory = memory,
                     .header_bytes = kTensorHeaderBytes,
                     .nonzero_count = header->nonzero_count,
                     .format = header->format,
                     .payload = {}});
  return ok();
}

Status FrameLayout::map_next(GstBuffer* buffer, GstMapFlags flags) {
  const auto next = static_cast<guint>(maps_.size());
  maps_.emplace_back(gst_buffer_peek_memory(buffer, next), flags);
  return maps_.back() ? ok() : Status(memory_not_mapped());
}

Status FrameLayout::map_merged(GstBuffer* buffer, GstMapFlags flags) {
  auto whole = one_memory(buffer);
  if (!whole) return whole.error();
  whole_ = *std::move(whole);
  copied_ = gst_buffer_get_size(buffer);
  if (flags & GST_MAP_WRITE) gst_buffer_replace_all_memory(buffer, gst_memory_ref(whole_.get()));
  maps_.emplace_back(whole_.get(), flags);
  return maps_[0] ? ok() : Status(memory_not_mapped());
}

Status FrameLayout::map_all(GstBuffer* buffer, GstMapFlags flags) {
  if (is_split_ && gst_buffer_n_memory(buffer) > 1) return map_merged(buffer, flags);
  while (maps_.size() < gst_buffer_n_memory(buffer))
    if (auto status = map_next(buffer, flags); !status) return status;
  return ok();
}

Status FrameLayout::map_payloads(GstBuffer* buffer, GstMapFlags flags) {
  if (auto status = map_all(buffer, flags); !status || places_.empty()) return status;
  const MappedMemory& last = maps_.back();  // of tensors that have no memory of their own
  const size_t before_last =
      places_.back().memory < 0 ? gst_buffer_get_size(buffer) - last.bytes().size() : 0;
  for (TensorPlace& place : places_) {
    const bool alone = place.memory >= 0;
    const MappedMemory& map = alone ? maps_[static_cast<size_t>(place.memory)] : last;
    const size_t at = (alone ? 0 : place.offset - before_last) + place.header_bytes;
    place.payload = map.bytes().subspan(at, place.size - place.header_bytes);
    place.capacity = map.capacity() - at;
  }
  return ok();
}

bool has_empty_tensor(GstBuffer* buffer) {
  const auto each_memory = [buffer](const auto& has) {
    for (guint i = 0; i < gst_buffer_n_memory(buffer); ++i)
      if (has(gst_buffer_peek_memory(buffer, i))) return true;
    return false;
  };
  if (!each_memory(is_deferred_memory)) {
    FrameLayout layout;
    return layout.locate(buffer, {Format::Flexible, {}, {}}) && layout.has_empty_tensor();
  }
  // Deferred memories are regions, which have elements: mapping would compute them.
  return each_memory([](GstMemory* memory) {
    if (is_deferred_memory(memory)) return false;
    const MappedMemory map(memory, GST_MAP_READ);
    if (!map) return false;
    const auto header = read_tensor_header(map.bytes());
    return header && header->spec.shape.is_empty();
  });
}

}  // namespace weir::gst
