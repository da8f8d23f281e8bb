// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/convert/converter_mode.hpp"

#include "core/text/text.hpp"

namespace weir {

Result<ConverterMode> parse_converter_mode(std::string_view text) {
  ConverterMode mode;
  if (strip(text).empty()) return mode;
  const auto parts = split(text, ":");
  const auto error = [&](Code code, const char* what) {
    return Error{.code = code,
                 .what = what,
                 .offered = "mode=" + std::string(text),
                 .needed = "custom-code:NAME or custom-script:PATH",
                 .fix = "tensor_converter mode=custom-code:NAME"};
  };
  if (parts.size() < 2 || strip(parts[1]).empty())
    return error(Code::OPTION_SYNTAX, "the mode has no name after a colon");
  const auto word = strip(parts[0]);
  if (equal_ignoring_case(word, "custom-code"))
    mode.kind = ConverterMode::Kind::CustomCode;
  else if (equal_ignoring_case(word, "custom-script"))
    mode.kind = ConverterMode::Kind::CustomScript;
  else
    return error(Code::MODE_UNKNOWN, "tensor_converter has no such mode");
  mode.name = strip(parts[1]);
  return mode;
}

}  // namespace weir
