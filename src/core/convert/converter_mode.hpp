// ConverterMode: the property mode of tensor_converter, "custom-code:NAME" or "custom-script:PATH".
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

// "" is ByCaps. OPTION_SYNTAX if the colon or the name is missing, MODE_UNKNOWN for an unknown
// keyword. Ignores the keyword's case and everything after a second colon.
Result<ConverterMode> parse_converter_mode(std::string_view text);

}  // namespace weir
