// The packed last memory of frames with more than 16 tensors
// (docs/compatibility/types-and-caps.md 1.6).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/tensor/packed_tensors.hpp"

#include <algorithm>
#include <cstring>
#include <string>

#include "core/tensor/tensor_header.hpp"

namespace weir {
namespace {

constexpr uint32_t kPackedMagic = 0xF00DC0DE;
constexpr size_t kExtraLimit = kTensorLimit - kMemoryLimit;
constexpr size_t kCountAt = 8, kFirstSizeAt = 16, kEntriesAt = 24, kEntryBytes = 80;
constexpr size_t kEntryTypeAt = 8, kEntryDimsAt = 12;

template <class T>
T read(std::span<const std::byte> bytes, size_t at) noexcept {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}
template <class T>
void write(std::span<std::byte> bytes, size_t at, T value) noexcept {
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

Error invalid_packing(std::string what, std::string offered, std::string needed) {
  return Error{.code = Code::HEADER_INVALID,
               .what = std::move(what),
               .offered = std::move(offered),
               .needed = std::move(needed),
               .fix = "check the element or program that wrote the stream"};
}

Result<TensorSpec> entry(std::span<const std::byte> memory, size_t index) {
  const size_t at = kEntriesAt + index * kEntryBytes;
  TensorSpec spec;
  const auto type = read<uint32_t>(memory, at + kEntryTypeAt);
  spec.type = static_cast<ElementType>(std::min(type, static_cast<uint32_t>(ElementType::End)));
  for (size_t i = 0; i < kRankLimit; ++i)
    spec.shape[i] = read<uint32_t>(memory, at + kEntryDimsAt + 4 * i);
  if (!spec.valid() || !spec.bytes())
    return invalid_packing(
        "an entry of the packed tensors is damaged",
        "tensor " + std::to_string(kMemoryLimit + index) + ": " + spec.to_string(),
        "a type and dimensions above 0");
  return spec;
}

size_t find_end(const std::vector<ByteRange>& ranges) {
  return ranges.empty() ? kPackedHeaderBytes : ranges.back().offset + ranges.back().size;
}

Status append(uint64_t size, size_t limit, std::vector<ByteRange>* ranges) {
  const size_t offset = find_end(*ranges);
  if (size > limit - offset)
    return invalid_packing("the packed tensors declare more bytes than their memory holds",
                           std::to_string(limit - offset) + " bytes left",
                           std::to_string(size) + " bytes for tensor " +
                               std::to_string(kMemoryLimit - 1 + ranges->size()));
  ranges->push_back({offset, static_cast<size_t>(size)});
  return ok();
}

// Static tensors: their sizes follow from the entries of the header.
Result<std::vector<ByteRange>> entry_ranges(std::span<const std::byte> memory, uint32_t extra) {
  std::vector<ByteRange> ranges;
  if (auto s = append(read<uint64_t>(memory, kFirstSizeAt), memory.size(), &ranges); !s)
    return s.error();
  for (size_t i = 0; i < extra; ++i) {
    const auto spec = entry(memory, i);
    if (!spec) return spec.error();
    if (auto s = append(*spec->bytes(), memory.size(), &ranges); !s) return s.error();
  }
  return ranges;
}

// Flexible and sparse tensors: each begins with a header of its own.
Result<std::vector<ByteRange>> chunk_ranges(std::span<const std::byte> memory, uint32_t extra) {
  std::vector<ByteRange> ranges;
  for (size_t i = 0; i <= extra; ++i) {
    const auto header = read_tensor_chunk(memory.subspan(find_end(ranges)));
    if (!header) return header.error();
    if (auto s = append(kTensorHeaderBytes + *header->payload_bytes(), memory.size(), &ranges); !s)
      return s.error();
  }
  return ranges;
}

}  // namespace

bool is_packed(std::span<const std::byte> memory) noexcept {
  return memory.size() >= kPackedHeaderBytes && read<uint32_t>(memory, 0) == kPackedMagic;
}

Result<std::vector<ByteRange>> read_packed_tensors(std::span<const std::byte> memory,
                                                   Format format) {
  if (!is_packed(memory))
    return invalid_packing(
        "the last memory of a frame with more than 16 tensors has no packed header",
        std::to_string(memory.size()) + " bytes", "19224 bytes that start with 0xF00DC0DE");
  const auto extra = read<uint32_t>(memory, kCountAt);
  if (extra < 1 || extra > kExtraLimit)
    return invalid_packing("the packed header has too few or too many tensors",
                           std::to_string(extra), "1 to 240");
  return format == Format::Static ? entry_ranges(memory, extra) : chunk_ranges(memory, extra);
}

void write_packed_header(std::span<const TensorSpec> tensors, std::span<const uint64_t> chunk_bytes,
                         std::span<std::byte, kPackedHeaderBytes> out) noexcept {
  std::fill(out.begin(), out.end(), std::byte{0});
  const size_t extra = std::min(tensors.size() - 1, kExtraLimit);
  write(out, 0, kPackedMagic);
  write(out, kCountAt, static_cast<uint32_t>(extra));
  write(out, kFirstSizeAt, chunk_bytes[0]);
  for (size_t i = 0; i < extra; ++i) {
    const TensorSpec& spec = tensors[i + 1];
    const size_t at = kEntriesAt + i * kEntryBytes;
    write(out, at + kEntryTypeAt, static_cast<uint32_t>(spec.type));
    for (size_t d = 0; d < kRankLimit; ++d) write(out, at + kEntryDimsAt + 4 * d, spec.shape[d]);
  }
}

Result<std::vector<ByteRange>> walk_chunks(std::span<const std::byte> memory, size_t limit) {
  std::vector<ByteRange> ranges;
  size_t at = 0;
  while (at < memory.size() || ranges.empty()) {
    const auto header = read_tensor_chunk(memory.subspan(at));
    if (!header) return header.error();
    const bool last = ranges.size() + 1 == limit;
    const size_t size = last ? memory.size() - at
                             : kTensorHeaderBytes + static_cast<size_t>(*header->payload_bytes());
    ranges.push_back({at, size});
    at += size;
  }
  return ranges;
}

}  // namespace weir
