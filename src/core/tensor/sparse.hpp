// Sparse tensors: header, nnz values in index order, nnz flat u32 indices.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "core/tensor/tensor_header.hpp"

namespace weir {

// The header of a dense tensor's sparse form; write_sparse() needs its payload_bytes(). Supports
// float16; minus zero counts as zero. FRAME_SIZE if `dense` does not have the size of `spec`,
// LIMIT_EXCEEDED above 2^32 - 1 elements.
Result<TensorHeader> sparse_header(const TensorSpec& spec, std::span<const std::byte> dense);
// Writes header, values and indices to `out`, which has kTensorHeaderBytes + payload_bytes() bytes.
// `header` belongs to the same `dense`.
void write_sparse(const TensorHeader& header, std::span<const std::byte> dense,
                  std::span<std::byte> out) noexcept;

// Reads the header of a sparse chunk whose dense form may be allocated: its payload is complete and
// the dense form has at most 4 GiB. HEADER_INVALID, LIMIT_EXCEEDED.
Result<TensorHeader> read_sparse_header(std::span<const std::byte> chunk);
// Expands a checked chunk to `dense`, which has spec.bytes() bytes and is overwritten completely.
// HEADER_INVALID if an index is out of range or indices do not ascend.
Status read_sparse(const TensorHeader& header, std::span<const std::byte> chunk,
                   std::span<std::byte> dense);

// The same, returning newly allocated memory.
Result<std::vector<std::byte>> to_sparse(const TensorSpec& spec, std::span<const std::byte> dense);
Result<std::vector<std::byte>> to_dense(std::span<const std::byte> chunk, TensorSpec* spec_out);

}  // namespace weir
