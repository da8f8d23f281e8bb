// The 128-byte header of each flexible or sparse tensor, and its bounds-checked parser.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/tensor/frame_spec.hpp"

namespace weir {

inline constexpr size_t kTensorHeaderBytes = 128;

struct TensorHeader {
  TensorSpec spec;
  Format format = Format::Static;
  MediaType media = MediaType::Tensor;
  uint32_t nonzero_count = 0;  // sparse only

  // Bytes after the header: the dense size, or nnz * (element size + 4) for sparse. Nullopt if it
  // exceeds 63 bits or the spec is invalid.
  std::optional<uint64_t> payload_bytes() const noexcept;
};

// Reads the first 128 bytes. Rejects short input, wrong magic or version, unknown type, format or
// media, bad dimensions, an overflowing product, and nnz above the element count.
Result<TensorHeader> read_tensor_header(std::span<const std::byte> bytes);
// The same, and requires the complete payload in `bytes`, which may be longer.
Result<TensorHeader> read_tensor_chunk(std::span<const std::byte> bytes);
void write_tensor_header(const TensorHeader& header,
                         std::span<std::byte, kTensorHeaderBytes> out) noexcept;

}  // namespace weir
