// Locates segments in their tensor, and copies those that are not contiguous.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <cstring>
#include <string>

#include "core/split/pick_list.hpp"
#include "core/split/segments.hpp"

namespace weir {
namespace {

std::string sized(const TensorSpec& spec) {
  return spec.to_string() + " = " + std::to_string(spec.bytes().value_or(0)) + " bytes";
}

// The number of bytes of the dimensions below `dimension`.
size_t inner_bytes(const TensorSpec& spec, size_t dimension) {
  size_t bytes = element_size(spec.type);
  for (size_t i = 0; i < dimension && i < spec.shape.rank(); ++i) bytes *= spec.shape[i];
  return bytes;
}

uint32_t get_extent(const Shape& shape, size_t dimension) {
  return std::max(shape[dimension], 1u);
}

bool same_but(const Shape& a, const Shape& b, size_t dimension) {
  for (size_t i = 0; i < kRankLimit; ++i)
    if (i != dimension && get_extent(a, i) != get_extent(b, i)) return false;
  return true;
}

// A run of bytes is a part of dimension k if all dimensions outside k are 1.
std::optional<Segment::Part> part_of_line(const Segment& segment, const TensorSpec& input) {
  const size_t k = input.shape.min_rank() - 1;
  const size_t inner = inner_bytes(input, k);
  if (!same_but(segment.spec.shape, input.shape, k) || segment.offset % inner != 0)
    return std::nullopt;
  return Segment::Part{k, static_cast<uint32_t>(segment.offset / inner),
                       get_extent(segment.spec.shape, k)};
}

Error beyond(const SplitRequest& request, const TensorSpec& input, size_t index, std::string needed,
             std::string segment) {
  return Error{.code = Code::SPEC_MISMATCH,
               .what = "the segments are larger than the tensor",
               .offered = sized(input),
               .needed = "segments 0 to " + std::to_string(request.segments.size() - 1) + " = " +
                         std::move(needed),
               .difference = "segment " + std::to_string(index) + " " + std::move(segment),
               .fix = "make tensorseg add up to the tensor"};
}

std::string sum_text(const std::vector<TensorSpec>& specs) {
  uint64_t sum = 0;
  for (const auto& spec : specs) {
    const auto bytes = spec.bytes();
    if (!bytes || __builtin_add_overflow(sum, *bytes, &sum)) return "beyond 64 bits";
  }
  return std::to_string(sum) + " bytes";
}

Error left_over(std::string offered, std::string used) {
  return Error{.code = Code::OPTION_VALUE,
               .what = "a part of the tensor is not covered by any segment",
               .offered = std::move(offered),
               .difference = "the segments are " + std::move(used),
               .fix = "make tensorseg add up to the tensor"};
}

Result<SplitPlan> in_a_line(const SplitRequest& request, const TensorSpec& input) {
  SplitPlan plan{input, {}, {}};
  const uint64_t total = *input.bytes();
  std::vector<TensorSpec> specs;
  for (const auto& shape : request.segments) specs.push_back({input.type, shape, ""});
  uint64_t at = 0;
  for (size_t i = 0; i < specs.size(); ++i) {
    const auto bytes = specs[i].bytes();
    if (!bytes || *bytes > total - at)
      return beyond(request, input, i, sum_text(specs),
                    "(" + specs[i].shape.to_string() + ") begins at byte " + std::to_string(at) +
                        " and has " + (bytes ? std::to_string(*bytes) : "too many") + " bytes");
    Segment segment;
    segment.index = i;
    segment.spec = specs[i];
    segment.offset = at;
    segment.block_bytes = segment.step_bytes = *bytes;
    segment.part = part_of_line(segment, input);
    plan.segments.push_back(segment);
    at += *bytes;
  }
  if (at < total) plan.left_over = left_over(sized(input), std::to_string(at) + " bytes");
  return plan;
}

// The size of each segment along the dimension.
Result<std::vector<uint32_t>> extents(const SplitRequest& request, const TensorSpec& input) {
  const size_t k = *request.dimension;
  const uint32_t extent = get_extent(input.shape, k);
  if (request.parts > 0) {
    if (!request.segments.empty())
      return Error{.code = Code::OPTION_VALUE,
                   .what = "tensorseg and split-parts both set the length of the segments",
                   .offered = "split-parts=" + std::to_string(request.parts),
                   .needed = "one of them",
                   .fix = "split-dim=" + std::to_string(k) +
                          " split-parts=" + std::to_string(request.parts)};
    if (extent % request.parts != 0)
      return Error{.code = Code::SPEC_MISMATCH,
                   .what = "a dimension cannot be split into that many equal parts",
                   .offered = input.to_string() + ", dimension " + std::to_string(k) + " is " +
                              std::to_string(extent),
                   .needed = "a multiple of split-parts=" + std::to_string(request.parts),
                   .difference = std::to_string(extent) + " / " + std::to_string(request.parts) +
                                 " leaves " + std::to_string(extent % request.parts),
                   .fix = "set the sizes in tensorseg"};
    return std::vector<uint32_t>(request.parts, extent / request.parts);
  }
  std::vector<uint32_t> out;
  for (size_t i = 0; i < request.segments.size(); ++i) {
    const Shape& segment = request.segments[i];
    const bool only_size = segment.rank() == 1;
    if (!only_size && !same_but(segment, input.shape, k))
      return Error{.code = Code::SPEC_MISMATCH,
                   .what = "a segment differs from the tensor in more than the split dimension",
                   .offered = input.to_string(),
                   .needed = "segments that differ in dimension " + std::to_string(k) + " only",
                   .difference = "segment " + std::to_string(i) + " is " + segment.to_string(),
                   .fix = "set only the sizes along the dimension: tensorseg=1,2"};
    out.push_back(only_size ? segment[0] : get_extent(segment, k));
  }
  return out;
}

Result<SplitPlan> along_dimension(const SplitRequest& request, const TensorSpec& input) {
  SplitPlan plan{input, {}, {}};
  const size_t k = *request.dimension;
  if (k >= kRankLimit)
    return Error{.code = Code::OPTION_VALUE,
                 .what = "split-dim is not a dimension",
                 .offered = std::to_string(k),
                 .needed = "0 to 15",
                 .fix = "split-dim=0"};
  const auto sizes = extents(request, input);
  if (!sizes) return sizes.error();
  const uint32_t extent = get_extent(input.shape, k);
  const size_t inner = inner_bytes(input, k);
  const size_t blocks = *input.bytes() / (inner * extent);
  uint64_t sum = 0, at = 0;
  for (const uint32_t size : *sizes) sum += size;
  for (size_t i = 0; i < sizes->size(); ++i) {
    const uint32_t size = (*sizes)[i];
    if (size > extent - at)
      return beyond(
          request, input, i,
          std::to_string(sum) + " along dimension " + std::to_string(k) + " of " +
              std::to_string(extent),
          "begins at " + std::to_string(at) + " and is " + std::to_string(size) + " long");
    Segment segment;
    segment.index = i;
    segment.spec = input;
    segment.spec.shape[k] = size;
    for (size_t d = input.shape.rank(); d < k; ++d) segment.spec.shape[d] = 1;
    segment.offset = at * inner;
    segment.block_bytes = inner * size;
    segment.step_bytes = inner * extent;
    segment.blocks = size == extent ? 1 : blocks;
    if (segment.dense()) segment.block_bytes = segment.step_bytes = *segment.spec.bytes();
    segment.part = Segment::Part{k, static_cast<uint32_t>(at), size};
    plan.segments.push_back(segment);
    at += size;
  }
  if (at < extent)
    plan.left_over = left_over(
        input.to_string() + ", dimension " + std::to_string(k) + " is " + std::to_string(extent),
        std::to_string(at) + " long");
  return plan;
}

template <size_t Bytes>
void gather(const Segment& segment, const std::byte* from, std::byte* to) {
  for (size_t i = 0; i < segment.blocks; ++i, from += segment.step_bytes, to += Bytes)
    std::memcpy(to, from, Bytes);
}

}  // namespace

Result<SplitPlan> plan_split(const SplitRequest& request, const TensorSpec& input) {
  if (!input.bytes())
    return Error{.code = Code::LIMIT_EXCEEDED,
                 .what = "a tensor is too large",
                 .offered = input.to_string(),
                 .needed = "at most 2^63 bytes"};
  if (request.segments.empty() && request.parts == 0)
    return Error{.code = Code::OPTION_VALUE,
                 .what = "tensor_split needs the segments",
                 .offered = "no tensorseg",
                 .needed = "the dimensions of each segment",
                 .fix = "tensor_split tensorseg=" + input.shape.to_string()};
  if (request.parts > 0 && !request.dimension)
    return Error{.code = Code::OPTION_VALUE,
                 .what = "split-parts needs split-dim",
                 .offered = "split-parts=" + std::to_string(request.parts),
                 .needed = "the dimension to split along",
                 .fix = "split-dim=0 split-parts=" + std::to_string(request.parts)};
  auto plan = request.dimension ? along_dimension(request, input) : in_a_line(request, input);
  if (!plan || request.picks.empty()) return plan;
  std::vector<bool> picked(plan->segments.size());
  for (const size_t index : request.picks) {
    if (index >= picked.size()) return index_beyond("tensorpick", "segment", index, picked.size());
    picked[index] = true;
  }
  std::erase_if(plan->segments, [&](const Segment& segment) { return !picked[segment.index]; });
  return plan;
}

void copy_segment(const Segment& segment, std::span<const std::byte> in, std::span<std::byte> out) {
  const std::byte* from = in.data() + segment.offset;
  std::byte* to = out.data();
  switch (segment.block_bytes) {  // calling memcpy for each costs more than copying the few bytes
    case 1:
      return gather<1>(segment, from, to);
    case 2:
      return gather<2>(segment, from, to);
    case 4:
      return gather<4>(segment, from, to);
    case 8:
      return gather<8>(segment, from, to);
    default:
      for (size_t i = 0; i < segment.blocks; ++i, from += segment.step_bytes)
        to = std::copy_n(from, segment.block_bytes, to);
  }
}

}  // namespace weir
