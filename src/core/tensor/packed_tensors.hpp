// More than 16 tensors: tensors from index 15 on share the last memory behind an "extra" header.
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

// Where tensors 15, 16, ... lie inside a packed 16th memory. `sizes` from the headers themselves:
// for a flexible stream each chunk keeps its 128-byte header and is walked by it.
Result<std::vector<ByteRange>> read_packed_tensors(std::span<const std::byte> memory,
                                                   Format format);
bool is_packed(std::span<const std::byte> memory) noexcept;  // magic and room for the header
// `tensors` and `chunk_bytes` are those of index 15 and up (at least 2). Writes the header only.
void write_packed_header(std::span<const TensorSpec> tensors, std::span<const uint64_t> chunk_bytes,
                         std::span<std::byte, kPackedHeaderBytes> out) noexcept;
// A memory that holds several header+payload chunks back to back: their ranges, at most `limit`,
// the rest stays in the last one (specification 1.6).
Result<std::vector<ByteRange>> walk_chunks(std::span<const std::byte> memory, size_t limit = 16);

}  // namespace weir
