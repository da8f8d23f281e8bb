// Concatenates rows of all inputs: short rows by shuffles, others in tiles that stay in the L1
// cache, or with non-temporal stores if blocks and tensor are large.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/merge/concatenation.hpp"

#include <algorithm>
#include <cstring>
#include <string>

#include "core/merge/interleave.hpp"
#include "core/simd/streamed_copy.hpp"

namespace weir {
namespace {

constexpr size_t kTileBytes = 16384;
constexpr size_t kStreamedBytes = size_t{8} << 20, kStreamedBlock = 1024;

uint32_t extent_or_one(const Shape& shape, size_t i) {
  return std::max<uint32_t>(shape[i], 1);
}

Error mismatch(const TensorSpec& offered, const TensorSpec& needed, size_t pad,
               std::string difference) {
  return Error{
      .code = Code::SPEC_MISMATCH,
      .what = "the tensors of two pads cannot be merged",
      .offered = "pad " + std::to_string(pad) + ": " + offered.to_string(),
      .needed = "as pad 0: " + needed.to_string() + "; only the merged dimension may differ",
      .difference = std::move(difference)};
}

Status fits(const TensorSpec& one, const TensorSpec& first, size_t pad, size_t dimension) {
  if (one.type != first.type) {
    Error error = mismatch(one, first, pad,
                           "type is " + std::string(to_string(one.type)) + ", needed is " +
                               std::string(to_string(first.type)));
    error.fix = "tensor_transform mode=typecast option=" + std::string(to_string(first.type));
    return error;
  }
  std::vector<size_t> differ;
  for (size_t d = 0; d < kRankLimit; ++d)
    if (extent_or_one(one.shape, d) != extent_or_one(first.shape, d)) differ.push_back(d);
  if (differ.empty() || (differ.size() == 1 && differ[0] == dimension)) return ok();
  const size_t d = differ[0] == dimension ? differ[1] : differ[0];
  Error error = mismatch(one, first, pad,
                         "dimension " + std::to_string(d) + " is " +
                             std::to_string(extent_or_one(one.shape, d)) + ", needed is " +
                             std::to_string(extent_or_one(first.shape, d)));
  // Tensors that differ along one dimension only can be concatenated along that dimension.
  if (differ.size() == 1) error.fix = "tensor_merge mode=linear option=" + std::to_string(d);
  return error;
}

// Copies `count` contiguous blocks to places that are `stride` bytes apart.
using Scatter = void (*)(const std::byte* in, std::byte* out, size_t block, size_t stride,
                         size_t count);
template <size_t kBlock>
void scatter_fixed(const std::byte* in, std::byte* out, size_t, size_t stride, size_t count) {
  for (size_t i = 0; i < count; ++i) std::memcpy(out + i * stride, in + i * kBlock, kBlock);
}
void scatter_any(const std::byte* in, std::byte* out, size_t block, size_t stride, size_t count) {
  for (size_t i = 0; i < count; ++i) std::memcpy(out + i * stride, in + i * block, block);
}
Scatter scatter_for(size_t block) {
  switch (block) {
    case 1:
      return scatter_fixed<1>;
    case 2:
      return scatter_fixed<2>;
    case 3:
      return scatter_fixed<3>;
    case 4:
      return scatter_fixed<4>;
    case 6:
      return scatter_fixed<6>;
    case 8:
      return scatter_fixed<8>;
    case 12:
      return scatter_fixed<12>;
    case 16:
      return scatter_fixed<16>;
    default:
      return scatter_any;
  }
}

}  // namespace

Result<Concatenation> Concatenation::plan(std::span<const TensorSpec> inputs, size_t dimension) {
  if (inputs.empty() || dimension >= kRankLimit)
    return Error{.code = Code::OPTION_VALUE,
                 .what = "there is nothing to merge along this dimension",
                 .offered = std::to_string(inputs.size()) + " tensors, dimension " +
                            std::to_string(dimension),
                 .needed = "at least one tensor, a dimension from 0 to 15"};
  const TensorSpec& first = inputs[0];
  Concatenation out;
  size_t rank = dimension + 1;
  uint64_t sum = 0;
  for (size_t pad = 0; pad < inputs.size(); ++pad) {
    if (auto status = fits(inputs[pad], first, pad, dimension); !status) return status.error();
    rank = std::max(rank, inputs[pad].shape.rank());
    sum += extent_or_one(inputs[pad].shape, dimension);
  }
  out.output_ = {first.type, first.shape.with_rank(rank), ""};
  out.output_.shape[dimension] = static_cast<uint32_t>(std::min<uint64_t>(sum, UINT32_MAX));
  if (sum > UINT32_MAX || !out.output_.bytes())
    return Error{.code = Code::LIMIT_EXCEEDED,
                 .what = "the merged tensor is too large",
                 .offered = std::to_string(sum) + " in dimension " + std::to_string(dimension),
                 .needed = "at most 4294967295, and less than 8 EiB together"};
  size_t inner = element_size(first.type);
  for (size_t d = 0; d < dimension; ++d) inner *= extent_or_one(first.shape, d);
  out.rows_ = 1;
  for (size_t d = dimension + 1; d < kRankLimit; ++d) out.rows_ *= extent_or_one(first.shape, d);
  for (const auto& input : inputs) {
    out.blocks_.push_back(inner * extent_or_one(input.shape, dimension));
    out.row_ += out.blocks_.back();
  }
  return out;
}

void Concatenation::run_streamed(std::span<const std::span<const std::byte>> inputs,
                                 std::byte* out) const {
  for (size_t row = 0; row < rows_; ++row)
    for (size_t pad = 0; pad < blocks_.size(); out += blocks_[pad++])
      copy_streamed(out, inputs[pad].data() + row * blocks_[pad], blocks_[pad]);
  flush_streamed();
}

void Concatenation::run(std::span<const std::span<const std::byte>> inputs,
                        std::span<std::byte> out) const {
  if (out.size() >= kStreamedBytes &&
      *std::min_element(blocks_.begin(), blocks_.end()) >= kStreamedBlock)
    return run_streamed(inputs, out.data());
  const size_t tile = std::max<size_t>(kTileBytes / row_, 1);
  const size_t done = interleave_rows(inputs, blocks_, rows_, out.data());
  for (size_t row = done; row < rows_; row += tile) {
    const size_t count = std::min(tile, rows_ - row);
    std::byte* to = out.data() + row * row_;
    for (size_t pad = 0; pad < blocks_.size(); ++pad) {
      const size_t block = blocks_[pad];
      scatter_for(block)(inputs[pad].data() + row * block, to, block, row_, count);
      to += block;
    }
  }
}

}  // namespace weir
