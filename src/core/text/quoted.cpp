// Writes bytes that are not printable ASCII as \xNN.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/text/quoted.hpp"

namespace weir {
namespace {

constexpr size_t kQuotedCharacters = 64;

void append_quoted(char c, std::string* out) {
  constexpr char kDigits[] = "0123456789abcdef";
  const auto value = static_cast<unsigned char>(c);
  if (value >= ' ' && value < 0x7F) {
    *out += c;
  } else {
    *out += "\\x";
    *out += kDigits[value >> 4];
    *out += kDigits[value & 0xF];
  }
}

}  // namespace

std::string quoted_text(std::string_view text) {
  std::string out = "\"";
  for (const char c : text.substr(0, kQuotedCharacters)) append_quoted(c, &out);
  out += text.size() > kQuotedCharacters ? "...\"" : "\"";
  return out;
}

}  // namespace weir
