// Lists of indices as users write them: which tensors of a frame, which segments of a tensor.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <string_view>
#include <vector>

#include "core/tensor/frame_spec.hpp"
#include "weir/result.hpp"

namespace weir {

// Between the entries of tensorpick and tensorseg.
inline constexpr std::string_view kPickSeparators = ",.;/";

// "0,2" with any of `separators`; blanks around a number are ignored, "" is an empty list.
// What is no number is an error that shows its place.
Result<std::vector<size_t>> parse_index_list(std::string_view property, std::string_view text,
                                             std::string_view separators);

// tensorpick of tensor_demux: "0,1:2" are two groups; ':' or '+' joins the tensors of one.
using TensorGroups = std::vector<std::vector<size_t>>;
Result<TensorGroups> parse_tensor_groups(std::string_view property, std::string_view text);

// Error of an index that is not below `count`.
Error index_beyond(std::string_view property, std::string_view things, size_t index, size_t count);

}  // namespace weir
