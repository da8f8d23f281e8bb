// Maps tensor buffers and checks them against the caps.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/buffer/frame_reader.hpp"

#include <string>

#include "gstcpp/buffer/frame_errors.hpp"
#include "gstcpp/buffer/memory_part.hpp"

namespace weir::gst {
void FrameReader::clear() noexcept {
  views_.clear();
  maps_.clear();
  whole_ = {};
}

Status FrameReader::read(GstBuffer* buffer, const FrameSpec& spec, GstMapFlags flags) {
  clear();
  copied_ = 0;
  const bool is_static = spec.format == Format::Static;
  Status status = is_static ? read_static(buffer, spec, flags) : read_headers(buffer, spec, flags);
  if (status && spec.format == Format::Flexible) status = check_dense();
  if (!status) clear();  // memory must not be mapped when the caller releases the buffer
  return status;
}

// Callers read as many bytes as the dimensions give; a sparse payload is shorter.
Status FrameReader::check_dense() const {
  for (size_t i = 0; i < views_.size(); ++i)
    if (views_[i].format == Format::Sparse)
      return Error{.code = Code::FORMAT_UNSUPPORTED,
                   .what = "a tensor of a flexible stream is sparse",
                   .offered = views_[i].spec.to_string(),
                   .needed = "dense tensors",
                   .difference = "tensor " + std::to_string(i),
                   .fix = "other/tensors,format=sparse ! tensor_sparse_dec"};
  return ok();
}

Status FrameReader::map(GstBuffer* buffer, GstMapFlags flags) {
  const guint n = gst_buffer_n_memory(buffer);
  for (guint i = 0; i < n; ++i) {
    maps_.emplace_back(gst_buffer_peek_memory(buffer, i), flags);
    if (!maps_.back()) return memory_not_mapped();
  }
  return ok();
}

void FrameReader::add_static(size_t index, const FrameSpec& spec, std::span<std::byte> bytes,
                             size_t capacity, int memory) {
  views_.push_back({spec.tensors[index], bytes, capacity, memory, 0, 0, Format::Static});
}

Status FrameReader::read_static(GstBuffer* buffer, const FrameSpec& spec, GstMapFlags flags) {
  const size_t count = spec.tensors.size();
  const size_t memories = gst_buffer_n_memory(buffer);
  const size_t expected = std::min(count, kMemoryLimit);
  if (memories != expected) return split_by_size(buffer, spec, flags);
  if (auto status = map(buffer, flags); !status) return status;
  const size_t alone = count > kMemoryLimit ? kMemoryLimit - 1 : count;
  for (size_t i = 0; i < alone; ++i) {
    const auto bytes = maps_[i].bytes();
    if (bytes.size() != spec.tensors[i].bytes())
      return wrong_frame_size(
          spec, std::to_string(bytes.size()) + " bytes in memory " + std::to_string(i),
          "tensor " + std::to_string(i) + " (" + spec.tensors[i].to_string() + ") needs " +
              std::to_string(spec.tensors[i].bytes().value_or(0)) + " bytes");
    add_static(i, spec, bytes, maps_[i].capacity(), static_cast<int>(i));
  }
  if (count <= kMemoryLimit) return ok();
  const auto last = maps_.back().bytes();
  auto ranges = read_packed_tensors(last, Format::Static);
  if (!ranges) return ranges.error();
  if (ranges->size() != count - alone)
    return wrong_frame_size(spec, std::to_string(alone + ranges->size()) + " tensors",
                            "number of tensors");
  for (size_t i = 0; i < ranges->size(); ++i) {
    const auto [offset, size] = (*ranges)[i];
    if (size != spec.tensors[alone + i].bytes())
      return wrong_frame_size(
          spec, std::to_string(size) + " bytes in packed tensor " + std::to_string(alone + i),
          "tensor " + std::to_string(alone + i));
    add_static(alone + i, spec, last.subspan(offset, size), maps_.back().capacity() - offset, -1);
  }
  return ok();
}

Status FrameReader::split_by_size(GstBuffer* buffer, const FrameSpec& spec, GstMapFlags flags) {
  const size_t total = gst_buffer_get_size(buffer);
  const auto needed = spec.bytes();
  if (!needed || total < *needed) return wrong_frame_size(spec, buffer, "the buffer is too small");
  auto whole = one_memory(buffer);
  if (!whole) return whole.error();
  whole_ = *std::move(whole);
  if (gst_buffer_n_memory(buffer) > 1) {
    copied_ = total;
    if (flags & GST_MAP_WRITE) gst_buffer_replace_all_memory(buffer, gst_memory_ref(whole_.get()));
  }
  maps_.emplace_back(whole_.get(), flags);
  if (!maps_.back()) return memory_not_mapped();
  const auto bytes = maps_.back().bytes();
  size_t offset = 0;
  for (size_t i = 0; i < spec.tensors.size(); ++i) {
    const auto size = static_cast<size_t>(*spec.tensors[i].bytes());
    add_static(i, spec, bytes.subspan(offset, size), maps_.back().capacity() - offset, -1);
    offset += size;
  }
  return ok();
}

Status FrameReader::add_chunk(std::span<std::byte> chunk, size_t capacity, int memory) {
  auto header = read_tensor_chunk(chunk);
  if (!header) return header.error();
  const auto size = static_cast<size_t>(*header->payload_bytes());
  views_.push_back({header->spec, chunk.subspan(kTensorHeaderBytes, size),
                    capacity - kTensorHeaderBytes, memory, kTensorHeaderBytes,
                    header->nonzero_count, header->format});
  return ok();
}

Status FrameReader::add_chunks(const std::vector<ByteRange>& ranges, const MappedMemory& memory) {
  for (const auto& [offset, size] : ranges)
    if (auto status =
            add_chunk(memory.bytes().subspan(offset, size), memory.capacity() - offset, -1);
        !status)
      return status;
  return ok();
}

Status FrameReader::read_single_memory() {
  const auto ranges = walk_chunks(maps_[0].bytes());
  if (!ranges) return ranges.error();
  if (ranges->size() > 1) return add_chunks(*ranges, maps_[0]);
  return add_chunk(maps_[0].bytes(), maps_[0].capacity(), 0);
}

Status FrameReader::read_headers(GstBuffer* buffer, const FrameSpec& spec, GstMapFlags flags) {
  if (auto status = map(buffer, flags); !status) return status;
  if (maps_.empty()) return buffer_is_empty();
  if (maps_.size() == 1) return read_single_memory();
  for (size_t i = 0; i < maps_.size(); ++i) {
    if (i + 1 == kMemoryLimit && is_packed(maps_[i].bytes())) {
      auto ranges = read_packed_tensors(maps_[i].bytes(), spec.format);
      if (!ranges) return ranges.error();
      return add_chunks(*ranges, maps_[i]);
    }
    if (auto s = add_chunk(maps_[i].bytes(), maps_[i].capacity(), static_cast<int>(i)); !s)
      return s;
  }
  return ok();
}

}  // namespace weir::gst
