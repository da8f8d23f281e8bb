// Frames of more than 16 tensors: tensors 15 and up share the last memory after an "extra" header.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "core/tensor/frame_spec.hpp"

namespace weir {

inline constexpr size_t kPackedHeaderBytes = 19224;

struct ByteRange {
  size_t offset = 0, size = 0;
  bool operator==(const ByteRange&) const = default;
};

// The ranges of tensors 15, 16, ... in a packed 16th memory. Their sizes come from the headers; in
// a flexible stream each chunk keeps its own 128-byte header, which gives its size.
Result<std::vector<ByteRange>> read_packed_tensors(std::span<const std::byte> memory,
                                                   Format format);
// Checks the magic and the room for the header.
bool is_packed(std::span<const std::byte> memory) noexcept;
// `tensors` and `chunk_bytes` are those of index 15 and up (at least 2). Writes the header only.
void write_packed_header(std::span<const TensorSpec> tensors, std::span<const uint64_t> chunk_bytes,
                         std::span<std::byte, kPackedHeaderBytes> out) noexcept;
// The ranges of several header+payload chunks in one memory, at most `limit`; the last range takes
// the rest (docs/compatibility/types-and-caps.md 1.6).
Result<std::vector<ByteRange>> walk_chunks(std::span<const std::byte> memory, size_t limit = 16);

}  // namespace weir
