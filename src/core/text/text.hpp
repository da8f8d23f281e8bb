// Text helpers for property grammars and messages. Independent of the locale.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace weir {

// Removes blanks (space, tab, line ends) at both ends.
std::string_view strip(std::string_view text) noexcept;
// Splits at any of `separators` and keeps empty parts; at most `limit` parts, where the last one
// takes the rest.
std::vector<std::string_view> split(std::string_view text, std::string_view separators,
                                    size_t limit = std::string_view::npos);
bool equal_ignoring_case(std::string_view a, std::string_view b) noexcept;  // ASCII
std::string lower(std::string_view text);                                   // ASCII
// Parses a decimal number; the whole text must match, without sign or blanks.
std::optional<uint64_t> parse_unsigned(std::string_view text) noexcept;
std::optional<int64_t> parse_signed(std::string_view text) noexcept;  // allows one leading + or -
// Parses a finite number such as "1", "-.5", "+1e-3"; the whole text must match.
std::optional<double> parse_double(std::string_view text) noexcept;
// The candidate with the smallest edit distance, and of several the one with the longest common
// start; "" if more than a third of it differs.
std::string nearest(std::string_view word, std::span<const std::string> candidates);
std::string time_text(uint64_t nanoseconds);  // "0:00:01.500000000"
// Returns "" for null.
inline std::string or_empty(const char* text) {
  return text ? text : "";
}

}  // namespace weir
