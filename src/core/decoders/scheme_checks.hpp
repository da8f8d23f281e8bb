// Checks and readers that the schemes of bounding_boxes share.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/decoders/box_scheme.hpp"

namespace weir::decoders {

// The error for tensors that a scheme does not take.
Failure wrong_tensors(const SchemeOptions& options,
                      std::span<const weir_tensor_info* const> tensors, const std::string& needed,
                      const std::string& fix = "");
// Throws wrong_tensors unless there are `count` tensors of one type.
void check_count_and_type(const SchemeOptions& options,
                          std::span<const weir_tensor_info* const> tensors, size_t count,
                          const std::string& needed);
// Whether the dimensions, innermost first, are these; all later ones must be 1.
bool has_dimensions(const weir_tensor_info& info, std::initializer_list<int64_t> dimensions);

// A parameter of option3; throws Failure (OPTION_SYNTAX) if `text` is no finite number. An empty
// text is `otherwise`.
float read_number(const SchemeOptions& options, std::string_view text, const char* meaning,
                  float otherwise);
// The parts of option3 between colons; throws Failure (OPTION_SYNTAX) for more than `limit`. Always
// returns `limit` parts: missing ones are empty.
std::vector<std::string_view> split_parameters(const SchemeOptions& options, size_t limit,
                                               const char* grammar);
// Throws Failure (LABELS_INVALID) unless there is a label file with `classes` lines, or with at
// least as many.
enum class LabelCount { Equal, AtLeast };
void check_labels(const SchemeOptions& options, int64_t classes, LabelCount rule,
                  const weir_tensor_info& tensor);

}  // namespace weir::decoders
