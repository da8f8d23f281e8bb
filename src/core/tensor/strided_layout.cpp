// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/tensor/strided_layout.hpp"

namespace weir {

std::optional<uint64_t> find_extent(const TensorSpec& tensor, const StridedLayout& layout) {
  if (!tensor.valid() || layout.strides.size() != tensor.shape.rank() ||
      layout.offset > static_cast<uint64_t>(INT64_MAX))
    return std::nullopt;
  int64_t low = static_cast<int64_t>(layout.offset), high = low;
  for (size_t i = 0; i < layout.strides.size(); ++i) {
    int64_t reach;
    if (__builtin_mul_overflow(static_cast<int64_t>(tensor.shape[i]) - 1, layout.strides[i],
                               &reach))
      return std::nullopt;
    int64_t& end = reach < 0 ? low : high;
    if (__builtin_add_overflow(end, reach, &end)) return std::nullopt;
  }
  const auto size = static_cast<int64_t>(element_size(tensor.type));
  if (low < 0 || __builtin_add_overflow(high, size, &high)) return std::nullopt;
  return static_cast<uint64_t>(high);
}

Runs make_runs(const TensorSpec& tensor, const StridedLayout& layout) {
  Runs out;
  out.offset = layout.offset;
  out.bytes = element_size(tensor.type);
  for (size_t i = 0; i < layout.strides.size(); ++i) {
    const uint64_t count = tensor.shape[i];
    const int64_t stride = layout.strides[i];
    if (count == 1) continue;
    if (out.steps.empty() && stride == static_cast<int64_t>(out.bytes)) {
      out.bytes *= count;
      continue;
    }
    if (!out.steps.empty()) {
      auto& last = out.steps.back();
      int64_t whole;
      if (!__builtin_mul_overflow(static_cast<int64_t>(last.count), last.stride, &whole) &&
          whole == stride) {
        last.count *= count;
        continue;
      }
    }
    out.steps.push_back({count, stride});
  }
  return out;
}

}  // namespace weir
