// The types of values in the text of caps, and their ranges.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <optional>
#include <string_view>

namespace weir {

// The types that have ranges. Guessed: the first of int, double and fraction that fits.
enum class RangeType { Guessed, Int, Int64, Double, Fraction };

// Whether the text is a number of this type that a range can begin or end with.
bool is_number(RangeType type, std::string_view text);
// Whether GStreamer can make a range of these two numbers and its step, which may be empty: the
// first is the smaller one, and both are multiples of the step. Decimal numbers only, and `min` and
// `max` for integers.
bool is_range(RangeType type, std::string_view first, std::string_view last, std::string_view step);

// Guessed: without a name; GStreamer tries int, double, fraction and boolean, and takes a string.
enum class CapsType {
  Text,
  Uint,
  Uint64,
  Float,
  Boolean,
  Bitmask,
  Guessed,
  Int,
  Int64,
  Double,
  Fraction,
  Buffer,
  List,
  Structure,
  Caps,
  Plain
};

// The type of a name or an abbreviation of GStreamer; nullopt for types that caps do not have.
std::optional<CapsType> caps_type(std::string_view name);
// Guessed for types without ranges.
RangeType range_type(CapsType type);
// Whether GStreamer certainly reads a value of this type from the text.
bool is_value(CapsType type, std::string_view text);

constexpr bool is_caps_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}
constexpr bool is_caps_digit(char c) {
  return c >= '0' && c <= '9';
}
constexpr bool is_caps_hex_digit(char c) {
  return is_caps_digit(c) || (c >= 'a' && c <= 'f') || (c >= 'A' && c <= 'F');
}
// Returns what g_ascii_isspace() returns.
constexpr bool is_caps_blank(char c) {
  return c == ' ' || c == '\t' || c == '\n' || c == '\f' || c == '\r';
}
// In a value without quotes.
constexpr bool is_caps_word(char c) {
  return is_caps_letter(c) || is_caps_digit(c) ||
         std::string_view("_-+/:.").find(c) != std::string_view::npos;
}

}  // namespace weir
