// Sparse tensors: header, nnz values in index order, nnz flat u32 indices.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "core/tensor/tensor_header.hpp"

namespace weir {

// The header of a dense tensor's sparse form; its payload_bytes() is what write_sparse() needs.
// float16 works, a minus zero counts as zero. FRAME_SIZE when `dense` has not the bytes of `spec`,
// LIMIT_EXCEEDED beyond 2^32 - 1 elements.
Result<TensorHeader> sparse_header(const TensorSpec& spec, std::span<const std::byte> dense);
// Header, values and indices into `out` of kTensorHeaderBytes + payload_bytes() bytes. `header` is
// that of the same `dense`.
void write_sparse(const TensorHeader& header, std::span<const std::byte> dense,
                  std::span<std::byte> out) noexcept;

// The header of a chunk whose dense form may be allocated: sparse, all of its payload there, at
// most 4 GiB dense. HEADER_INVALID, LIMIT_EXCEEDED.
Result<TensorHeader> read_sparse_header(std::span<const std::byte> chunk);
// Values and indices of a checked chunk into `dense`, which has spec.bytes() bytes and is filled
// wholly. HEADER_INVALID for an index out of range or indices that do not ascend.
Status read_sparse(const TensorHeader& header, std::span<const std::byte> chunk,
                   std::span<std::byte> dense);

// The same with memory of their own.
Result<std::vector<std::byte>> to_sparse(const TensorSpec& spec, std::span<const std::byte> dense);
Result<std::vector<std::byte>> to_dense(std::span<const std::byte> chunk, TensorSpec* spec_out);

}  // namespace weir
