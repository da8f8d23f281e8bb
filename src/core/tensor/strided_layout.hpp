// StridedLayout: a tensor stored with gaps, such as a padded picture, a region of one, or a part
// along one dimension.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/tensor/frame_spec.hpp"

namespace weir {

struct StridedLayout {
  uint64_t offset = 0;           // bytes, to the first element
  std::vector<int64_t> strides;  // bytes, one for each dimension, innermost first; may be negative
};

// The bytes from the start of the memory to the end of the last element. Nullopt if an element
// starts before the memory, a number exceeds 63 bits, or the ranks differ.
std::optional<uint64_t> find_extent(const TensorSpec& tensor, const StridedLayout& layout);

// The same elements as contiguous runs of `bytes`, and how often and at which stride they repeat,
// innermost first. Contiguous dimensions are merged. Precondition: find_extent() has a value.
struct Runs {
  struct Step {
    uint64_t count;
    int64_t stride;  // bytes
  };
  uint64_t offset = 0;
  uint64_t bytes = 0;
  std::vector<Step> steps;  // empty: the tensor is dense
};
Runs make_runs(const TensorSpec& tensor, const StridedLayout& layout);

// Calls f(offset of a run) for each run in element order until f returns false.
template <class F>
void for_each_run(const Runs& runs, F&& f) {
  std::array<uint64_t, kRankLimit> at{};
  auto offset = static_cast<int64_t>(runs.offset);
  while (f(static_cast<uint64_t>(offset))) {
    size_t i = 0;
    for (; i < runs.steps.size(); ++i) {
      offset += runs.steps[i].stride;
      if (++at[i] < runs.steps[i].count) break;
      offset -= static_cast<int64_t>(runs.steps[i].count) * runs.steps[i].stride;
      at[i] = 0;
    }
    if (i == runs.steps.size()) return;
  }
}

}  // namespace weir
