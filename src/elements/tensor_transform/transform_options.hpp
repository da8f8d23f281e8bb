// What the properties of tensor_transform say, and what becomes of a change while frames flow.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <optional>
#include <string>

#include "core/transform/transform.hpp"
#include "elements/tensor_transform/frame_transformer.hpp"
#include "weir/result.hpp"

namespace weir {

struct TransformSettings {
  bool silent = true;
  transform::Mode mode = transform::Mode::Unknown;
  std::optional<std::string> option;
  bool acceleration = true;
  std::string apply;
};

// A mode and an option; both may come as late as the first frame.
inline bool is_set(const TransformSettings& settings) {
  return settings.mode != transform::Mode::Unknown && settings.option.has_value();
}

struct TransformOptions {
  TransformSettings settings;
  transform::Operation operation;
  TensorChoice choice;
};

// Errors: OPTION_SYNTAX where mode and option are not set, or what the parser says of one.
Result<TransformOptions> parse_options(const TransformSettings& settings);

// Whether the property `name` may become as `wanted` says. A mode and its option come one after the
// other: only what fits no mode is refused.
Status check_change_of(const char* name, const TransformSettings& wanted);

}  // namespace weir
