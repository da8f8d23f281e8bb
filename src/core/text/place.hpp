// place_in: where in a text something is wrong, as the "first difference" of an Error.
#pragma once
#include <string>
#include <string_view>

namespace weir {

// "at character 3:", below it the text, below that a caret; "at the end:" behind the last one.
inline std::string place_in(std::string_view text, size_t position) {
  const std::string indent = "    ";
  const std::string place = position >= text.size()
                                ? std::string("at the end:\n")
                                : "at character " + std::to_string(position + 1) + ":\n";
  return place + indent + std::string(text) + "\n" + indent + std::string(position, ' ') + "^";
}

}  // namespace weir
