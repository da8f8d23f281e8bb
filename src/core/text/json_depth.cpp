// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/text/json_depth.hpp"

#include <algorithm>

namespace weir {

int json_depth(std::string_view text) noexcept {
  int depth = 0, deepest = 0;
  bool is_string = false;
  for (size_t i = 0; i < text.size(); ++i) {
    if (is_string && text[i] == '\\')
      ++i;
    else if (text[i] == '"')
      is_string = !is_string;
    else if (!is_string && (text[i] == '[' || text[i] == '{'))
      deepest = std::max(deepest, ++depth);
    else if (!is_string && (text[i] == ']' || text[i] == '}'))
      --depth;
  }
  return deepest;
}

}  // namespace weir
