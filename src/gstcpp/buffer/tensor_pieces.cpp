// Shares tensor memories out of buffers and packs them into one memory.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/buffer/tensor_pieces.hpp"

#include <cstring>
#include <numeric>
#include <string>

#include "core/tensor/packed_tensors.hpp"
#include "core/tensor/tensor_header.hpp"
#include "gstcpp/buffer/allocation.hpp"
#include "gstcpp/buffer/frame_errors.hpp"
#include "gstcpp/buffer/memory_part.hpp"

namespace weir::gst {
namespace {

size_t size_of(GstMemory* memory) {
  return gst_memory_get_sizes(memory, nullptr, nullptr);
}

// Shares a part of a memory, or copies it when it cannot be shared.
Result<Ref<GstMemory>> part_of(GstMemory* memory, ByteRange range, Ledger* ledger) {
  bool copied = false;
  auto part = gst::part_of(memory, range.offset, range.size, &copied);
  if (copied) ledger->copied(range.size);
  return part;
}

Status append_ranges(GstMemory* memory, const std::vector<ByteRange>& ranges, Ledger* ledger,
                     std::vector<TensorPiece>* pieces) {
  for (const auto& range : ranges) {
    auto part = part_of(memory, range, ledger);
    if (!part) return part.error();
    pieces->push_back({*std::move(part), {}});
  }
  return ok();
}

// Reads the headers of the pieces from index `first` on.
Status read_specs(std::vector<TensorPiece>* pieces, size_t first) {
  for (size_t i = first; i < pieces->size(); ++i) {
    TensorPiece& piece = (*pieces)[i];
    const MappedMemory map(piece.memory.get(), GST_MAP_READ);
    if (!map) return memory_not_mapped();
    const auto header = read_tensor_chunk(map.bytes());
    if (!header) return header.error();
    piece.spec = header->spec;
  }
  return ok();
}

bool has_layout(GstBuffer* buffer, const FrameSpec& spec, size_t alone) {
  for (size_t i = 0; i < alone; ++i)
    if (size_of(gst_buffer_peek_memory(buffer, static_cast<guint>(i))) != spec.tensors[i].bytes())
      return false;
  return true;
}

// Of a buffer with a memory for each tensor; the last of 16 holds all further tensors.
Status append_memories(GstBuffer* buffer, const FrameSpec& spec, Ledger* ledger,
                       std::vector<TensorPiece>* pieces) {
  const size_t count = spec.tensors.size();
  const size_t alone = count > kMemoryLimit ? kMemoryLimit - 1 : count;
  if (!has_layout(buffer, spec, alone)) return wrong_frame_size(spec, buffer, "");
  for (size_t i = 0; i < alone; ++i)
    pieces->push_back(
        {Ref<GstMemory>::share(gst_buffer_peek_memory(buffer, static_cast<guint>(i))), {}});
  if (count <= kMemoryLimit) return ok();
  GstMemory* last = gst_buffer_peek_memory(buffer, kMemoryLimit - 1);
  std::vector<ByteRange> ranges;
  {
    const MappedMemory map(last, GST_MAP_READ);
    if (!map) return memory_not_mapped();
    auto read = read_packed_tensors(map.bytes(), Format::Static);
    if (!read) return read.error();
    ranges = *std::move(read);
  }
  if (ranges.size() != count - alone) return wrong_frame_size(spec, buffer, "");
  for (size_t i = 0; i < ranges.size(); ++i)
    if (ranges[i].size != spec.tensors[alone + i].bytes())
      return wrong_frame_size(spec, buffer, "");
  return append_ranges(last, ranges, ledger, pieces);
}

// Of a buffer whose tensors follow each other, wherever its memories end.
Status append_split(GstBuffer* buffer, const FrameSpec& spec, Ledger* ledger,
                    std::vector<TensorPiece>* pieces) {
  const auto needed = spec.bytes();
  if (!needed || gst_buffer_get_size(buffer) < *needed) return wrong_frame_size(spec, buffer, "");
  if (gst_buffer_n_memory(buffer) > 1) ledger->copied(gst_buffer_get_size(buffer));
  const auto all = one_memory(buffer);
  if (!all) return all.error();
  std::vector<ByteRange> ranges;
  size_t offset = 0;
  for (const auto& tensor : spec.tensors) {
    ranges.push_back({offset, static_cast<size_t>(*tensor.bytes())});
    offset += ranges.back().size;
  }
  return append_ranges(all->get(), ranges, ledger, pieces);
}

Status append_static(GstBuffer* buffer, const FrameSpec& spec, Ledger* ledger,
                     std::vector<TensorPiece>* pieces) {
  const size_t count = spec.tensors.size(), first = pieces->size();
  const bool has_memories = gst_buffer_n_memory(buffer) == std::min(count, kMemoryLimit);
  if (auto status = has_memories ? append_memories(buffer, spec, ledger, pieces)
                                 : append_split(buffer, spec, ledger, pieces);
      !status)
    return status;
  for (size_t i = 0; i < count; ++i) (*pieces)[first + i].spec = spec.tensors[i];
  return ok();
}

// Splits one memory of a flexible stream into its chunks.
Result<std::vector<ByteRange>> chunks_of(GstMemory* memory, guint index, guint memories) {
  const MappedMemory map(memory, GST_MAP_READ);
  if (!map) return memory_not_mapped();
  if (memories == 1) return walk_chunks(map.bytes());
  if (index + 1 == kMemoryLimit && is_packed(map.bytes()))
    return read_packed_tensors(map.bytes(), Format::Flexible);
  return std::vector<ByteRange>{{0, map.bytes().size()}};
}

Status append_flexible(GstBuffer* buffer, Ledger* ledger, std::vector<TensorPiece>* pieces) {
  const size_t first = pieces->size();
  const guint memories = gst_buffer_n_memory(buffer);
  if (memories == 0) return buffer_is_empty();
  for (guint i = 0; i < memories; ++i) {
    GstMemory* memory = gst_buffer_peek_memory(buffer, i);
    const auto ranges = chunks_of(memory, i, memories);
    if (!ranges) return ranges.error();
    if (ranges->size() == 1)
      pieces->push_back({Ref<GstMemory>::share(memory), {}});
    else if (auto status = append_ranges(memory, *ranges, ledger, pieces); !status)
      return status;
  }
  return read_specs(pieces, first);
}

}  // namespace

Status append_pieces(GstBuffer* buffer, const FrameSpec& spec, Ledger* ledger,
                     std::vector<TensorPiece>* pieces) {
  if (spec.format == Format::Static) return append_static(buffer, spec, ledger, pieces);
  return append_flexible(buffer, ledger, pieces);
}

Result<TensorPiece> make_piece(const TensorHeader& header, std::span<const std::byte> bytes) {
  auto memory = allocate_memory(kTensorHeaderBytes + bytes.size());
  if (!memory) return memory.error();
  const MappedMemory to(memory->get(), GST_MAP_WRITE);
  if (!to) return memory_not_mapped();
  write_tensor_header(header, to.bytes().first<kTensorHeaderBytes>());
  std::memcpy(to.bytes().data() + kTensorHeaderBytes, bytes.data(), bytes.size());
  return TensorPiece{*std::move(memory), header.spec};
}

Result<TensorPiece> with_header(const TensorPiece& piece, Ledger* ledger) {
  const MappedMemory from(piece.memory.get(), GST_MAP_READ);
  if (!from) return memory_not_mapped();
  TensorHeader header;
  header.spec = piece.spec;
  auto out = make_piece(header, from.bytes());
  if (out) ledger->copied(from.bytes().size());
  return out;
}

namespace {

Error too_many(size_t count) {
  return Error{.code = Code::LIMIT_EXCEEDED,
               .what = "a frame has too many tensors",
               .offered = std::to_string(count),
               .needed = "at most 256"};
}

using Fill = std::function<Status(size_t n, std::span<std::byte> bytes)>;

// Appends the tensors from `first` on as one memory that starts with the packed header.
Status append_packed(std::span<const TensorSpec> specs, std::span<const uint64_t> sizes,
                     size_t first, GstBuffer* buffer, const Fill& fill) {
  const auto total = std::accumulate(sizes.begin(), sizes.end(), uint64_t{kPackedHeaderBytes});
  auto memory = allocate_memory(static_cast<size_t>(total));
  if (!memory) return memory.error();
  {
    const MappedMemory map(memory->get(), GST_MAP_WRITE);
    if (!map) return memory_not_mapped();
    write_packed_header(specs, sizes, map.bytes().first<kPackedHeaderBytes>());
    size_t at = kPackedHeaderBytes;
    for (size_t i = 0; i < sizes.size(); ++i) {
      const auto size = static_cast<size_t>(sizes[i]);
      if (auto status = fill(first + i, map.bytes().subspan(at, size)); !status) return status;
      at += size;
    }
  }
  gst_buffer_append_memory(buffer, memory->release());
  return ok();
}

}  // namespace

Status append_filled(std::span<const TensorSpec> specs, std::span<const uint64_t> sizes,
                     GstBuffer* buffer, const Fill& fill) {
  if (specs.size() > kTensorLimit) return too_many(specs.size());
  const size_t alone = specs.size() > kMemoryLimit ? kMemoryLimit - 1 : specs.size();
  for (size_t i = 0; i < alone; ++i) {
    auto memory = allocate_memory(static_cast<size_t>(sizes[i]));
    if (!memory) return memory.error();
    {
      const MappedMemory map(memory->get(), GST_MAP_WRITE);
      if (!map) return memory_not_mapped();
      if (auto status = fill(i, map.bytes()); !status) return status;
    }
    gst_buffer_append_memory(buffer, memory->release());
  }
  if (alone == specs.size()) return ok();
  return append_packed(specs.subspan(alone), sizes.subspan(alone), alone, buffer, fill);
}

Status append_tensors(std::span<TensorPiece> pieces, GstBuffer* buffer, Ledger* ledger) {
  if (pieces.size() > kTensorLimit) return too_many(pieces.size());
  const size_t alone = pieces.size() > kMemoryLimit ? kMemoryLimit - 1 : pieces.size();
  for (size_t i = 0; i < alone; ++i) gst_buffer_append_memory(buffer, pieces[i].memory.release());
  if (alone == pieces.size()) return ok();
  std::vector<TensorSpec> specs;
  std::vector<uint64_t> sizes;
  for (size_t i = alone; i < pieces.size(); ++i) {
    specs.push_back(pieces[i].spec);
    sizes.push_back(size_of(pieces[i].memory.get()));
  }
  return append_packed(specs, sizes, alone, buffer,
                       [&](size_t n, std::span<std::byte> bytes) -> Status {
                         const MappedMemory from(pieces[n].memory.get(), GST_MAP_READ);
                         if (!from) return memory_not_mapped();
                         std::memcpy(bytes.data(), from.bytes().data(), bytes.size());
                         ledger->copied(bytes.size());
                         return ok();
                       });
}

}  // namespace weir::gst
