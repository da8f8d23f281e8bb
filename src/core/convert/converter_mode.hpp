// The property mode of tensor_converter: "custom-code:NAME", "custom-script:PATH".
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <string_view>

#include "weir/result.hpp"

namespace weir {

struct ConverterMode {
  enum class Kind { ByCaps, CustomCode, CustomScript };
  Kind kind = Kind::ByCaps;
  std::string name;  // of the function, or path of the script
};

// "" is ByCaps. OPTION_SYNTAX without a colon or without anything behind it, MODE_UNKNOWN for
// another word. Case of the word is ignored; what stands behind a second colon is too.
Result<ConverterMode> parse_converter_mode(std::string_view text);

}  // namespace weir
