// join: concatenates the texts of a range with a separator.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <string_view>
#include <utility>

namespace weir {

// Concatenates to_text(item) of each item with `separator` in between; "" for an empty range.
// `to_text` returns anything that std::string can append.
template <class Range, class ToText>
std::string join(const Range& items, std::string_view separator, ToText&& to_text) {
  std::string out;
  bool is_first = true;
  for (const auto& item : items) {
    if (!std::exchange(is_first, false)) out += separator;
    out += to_text(item);
  }
  return out;
}

template <class Range>
std::string join(const Range& items, std::string_view separator) {
  return join(
      items, separator, [](const auto& item) -> const auto& { return item; });
}

}  // namespace weir
