// Index lists of users: the tensors of a frame, or the segments of a tensor.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <string_view>
#include <vector>

#include "core/tensor/frame_spec.hpp"
#include "weir/result.hpp"

namespace weir {

// Separators of tensorpick and tensorseg.
inline constexpr std::string_view kPickSeparators = ",.;/";

// "0,2" with any of `separators`; ignores blanks around numbers; "" is an empty list. Anything else
// is an error with its position.
Result<std::vector<size_t>> parse_index_list(std::string_view property, std::string_view text,
                                             std::string_view separators);

// tensorpick of tensor_demux: "0,1:2" is two groups; ':' or '+' joins the tensors of a group.
using TensorGroups = std::vector<std::vector<size_t>>;
Result<TensorGroups> parse_tensor_groups(std::string_view property, std::string_view text);

// The error for an index that is not below `count`.
Error index_beyond(std::string_view property, std::string_view things, size_t index, size_t count);

}  // namespace weir
