// input-combination and output-combination: the tensors that go to the model and leave the filter.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <string_view>
#include <vector>

#include "core/tensor/frame_spec.hpp"

namespace weir {

// "0,2": indices of the stream's tensors in the model's order. "" is an empty list (all).
Result<std::vector<size_t>> parse_input_combination(std::string_view text);

// "i0,o1": first all chosen inputs, then the chosen outputs in model order.
struct OutputCombination {
  std::vector<size_t> inputs;
  std::vector<size_t> outputs;  // ascending
  bool empty() const noexcept { return inputs.empty() && outputs.empty(); }
};
Result<OutputCombination> parse_output_combination(std::string_view text);

// The chosen tensors of `tensors`; an empty choice means all. If an index is out of range, the
// error names `property`.
Result<std::vector<TensorSpec>> choose_tensors(const std::vector<TensorSpec>& tensors,
                                               const std::vector<size_t>& choice,
                                               std::string_view property);

}  // namespace weir
