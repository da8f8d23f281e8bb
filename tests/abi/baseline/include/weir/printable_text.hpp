// Text of unknown origin for terminals and logs: UTF-8 without control characters.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace weir {

// Returns the length of the UTF-8 sequence at the start of `text`; 0 if it is invalid. RFC 3629: no
// overlong forms, no surrogates, nothing above U+10FFFF.
constexpr size_t utf8_sequence(std::string_view text) noexcept {
  const auto at = [&](size_t i) { return static_cast<unsigned char>(text[i]); };
  if (text.empty()) return 0;
  const unsigned lead = at(0);
  if (lead < 0x80) return 1;
  const size_t length = lead >= 0xC2 && lead < 0xE0   ? 2
                        : lead >= 0xE0 && lead < 0xF0 ? 3
                        : lead >= 0xF0 && lead < 0xF5 ? 4
                                                      : 0;
  if (length == 0 || text.size() < length) return 0;
  for (size_t i = 1; i < length; ++i)
    if ((at(i) & 0xC0) != 0x80) return 0;
  const unsigned second = at(1);
  const bool too_long = (lead == 0xE0 && second < 0xA0) || (lead == 0xF0 && second < 0x90);
  const bool surrogate = lead == 0xED && second >= 0xA0;
  const bool too_great = lead == 0xF4 && second >= 0x90;
  return too_long || surrogate || too_great ? 0 : length;
}

// Returns whether a terminal acts on this UTF-8 sequence instead of showing it: C0, DEL and C1
// control characters, and those that change the direction of text (U+202A to U+202E, U+2066 to
// U+2069).
constexpr bool is_terminal_control(std::string_view sequence) noexcept {
  const auto at = [&](size_t i) { return static_cast<unsigned char>(sequence[i]); };
  if (sequence.size() == 1) return at(0) < ' ' || at(0) == 0x7F;
  if (sequence.size() == 2) return at(0) == 0xC2 && at(1) < 0xA0;
  if (sequence.size() != 3 || at(0) != 0xE2) return false;
  return (at(1) == 0x80 && at(2) >= 0xAA && at(2) <= 0xAE) ||
         (at(1) == 0x81 && at(2) >= 0xA6 && at(2) <= 0xA9);
}

// Appends such a sequence as JSON writes it in a string: \uNNNN.
inline void append_json_escape(std::string_view sequence, std::string* out) {
  constexpr char kDigits[] = "0123456789abcdef";
  const auto bits = [&](size_t i, unsigned mask) {
    return static_cast<unsigned char>(sequence[i]) & mask;
  };
  const unsigned code = sequence.size() == 1 ? bits(0, 0x7F)
                        : sequence.size() == 2
                            ? bits(0, 0x1F) << 6 | bits(1, 0x3F)
                            : bits(0, 0x0F) << 12 | bits(1, 0x3F) << 6 | bits(2, 0x3F);
  *out += "\\u";
  for (int shift = 12; shift >= 0; shift -= 4) *out += kDigits[code >> shift & 0xF];
}

// Returns `text` with control characters and bytes that are not UTF-8 written as \xNN, byte by
// byte. Line feeds and tabs stay. The result is valid UTF-8 and does not change when it is escaped
// again.
inline std::string printable_text(std::string_view text) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string out;
  out.reserve(text.size());
  while (!text.empty()) {
    const size_t length = utf8_sequence(text);
    const std::string_view part = text.substr(0, std::max<size_t>(length, 1));
    if (length > 0 && (text[0] == '\n' || text[0] == '\t' || !is_terminal_control(part))) {
      out += part;
    } else {
      for (const char c : part) {
        const auto value = static_cast<unsigned char>(c);
        out += "\\x";
        out += kDigits[value >> 4];
        out += kDigits[value & 0xF];
      }
    }
    text.remove_prefix(part.size());
  }
  return out;
}

}  // namespace weir
