// Checks the texts of headers.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "net/header_text.hpp"

#include <algorithm>

namespace weir::net {

bool is_header_value(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](char c) { return c >= ' ' && c <= '~'; });
}

bool is_trace_parent(std::string_view text) {
  constexpr std::string_view kForm = "xx-xxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxx-xxxxxxxxxxxxxxxx-xx";
  constexpr std::string_view kDigits = "0123456789abcdef";
  return std::equal(text.begin(), text.end(), kForm.begin(), kForm.end(), [&](char c, char form) {
    return form == 'x' ? kDigits.find(c) != std::string_view::npos : c == form;
  });
}

}  // namespace weir::net
