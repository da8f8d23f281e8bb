// The parsed properties of tensor_transform, and checks of changes while frames flow.
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
  std::optional<std::string> option_taken;  // the last one that was not refused
  std::optional<Error> refused;             // set if the last one was
  bool acceleration = true;
  std::string apply;
};

// Whether mode and option are set; both may be set as late as the first frame.
inline bool is_set(const TransformSettings& settings) {
  return settings.mode != transform::Mode::Unknown && settings.option.has_value();
}

struct TransformOptions {
  TransformSettings settings;
  transform::Operation operation;
  TensorChoice choice;
};

// Errors: OPTION_SYNTAX when mode or option is not set, or the parser's error.
Result<TransformOptions> parse_options(const TransformSettings& settings);

// Refuses an option that does not fit the mode, and keeps the one before. An option that is set
// before the mode is taken as it is.
Status refuse_unfit_option(TransformSettings* settings);

// Whether the property `name` may change to its value in `wanted`. Mode and option are set one
// after the other: only values that fit no mode are rejected.
Status check_option_change(const char* name, const TransformSettings& wanted);

}  // namespace weir
