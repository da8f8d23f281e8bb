// DecoderOptions: what the properties of tensor_decoder pass to its decoder.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "weir/result.hpp"

namespace weir {

// The properties of tensor_decoder with which a decoder is opened.
struct DecoderSettings {
  bool silent = true;
  std::string mode;
  std::optional<std::string> option1, option2, option3, option4, option5, option6, option7, option8,
      option9;
  float threshold = -1, iou = -1;  // below 0: not set
  std::optional<std::string> labels;
  uint32_t max_results = 0;  // 0: not set
  std::optional<std::string> classes, custom;
  std::string config_file;
};

// An option with a name: from the property of the same name, or from custom=.
struct NamedOption {
  std::string key, value;
  bool is_custom = false;
  std::string to_string() const;  // as in a pipeline: "iou=0.5", "custom=head:yolov8"
};

struct DecoderOptions {
  std::array<std::optional<std::string>, 9> numbered;  // option1 to option9
  std::vector<NamedOption> named;                      // a property precedes custom=
};

// OPTION_SYNTAX if custom= is not key:value,key:value.
Result<DecoderOptions> make_options(const DecoderSettings& settings);

// OPTION_VALUE if custom= has a key that is not among `declared`.
Status check_custom(const std::string& mode, std::span<const std::string> declared,
                    const DecoderOptions& options);

// Removes the named options that are not among `declared`, and those that are set again by custom=.
// Returns a warning for each.
std::vector<Error> remove_undeclared(const std::string& mode, std::span<const std::string> declared,
                                     DecoderOptions* options);

}  // namespace weir
