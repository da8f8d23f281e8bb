// Sparse tensors: header, nnz values in index order, nnz flat u32 indices.
#pragma once
#include <cstddef>
#include <span>
#include <vector>

#include "core/tensor/tensor_header.hpp"

namespace weir {

// Dense -> header + values + indices. float16 works; more than 2^32 elements are refused.
Result<std::vector<std::byte>> to_sparse(const TensorSpec& spec, std::span<const std::byte> dense);
// Sparse chunk (with header) -> dense bytes. An index out of range, indices not ascending, nnz
// beyond the array or a short memory is an error.
Result<std::vector<std::byte>> to_dense(std::span<const std::byte> chunk, TensorSpec* spec_out);

}  // namespace weir
