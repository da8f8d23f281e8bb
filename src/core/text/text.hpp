// Small text helpers for the grammars of properties, and for messages. Locale plays no part.
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

// Without blanks (space, tab, line ends) at both ends.
std::string_view strip(std::string_view text) noexcept;
// Parts between any of `separators`, empty ones too; at most `limit` parts, the last takes the
// rest.
std::vector<std::string_view> split(std::string_view text, std::string_view separators,
                                    size_t limit = std::string_view::npos);
bool equal_ignoring_case(std::string_view a, std::string_view b) noexcept;  // ASCII
std::string lower(std::string_view text);                                   // ASCII
// The whole text must be a decimal number; no sign, no blanks.
std::optional<uint64_t> parse_unsigned(std::string_view text) noexcept;
std::optional<int64_t> parse_signed(std::string_view text) noexcept;  // one leading + or - allowed
// The whole text must be a finite number such as "1", "-.5", "+1e-3".
std::optional<double> parse_double(std::string_view text) noexcept;
// The candidate with the least edit distance, "" when none is close (more than a third differs).
std::string nearest(std::string_view word, std::span<const std::string> candidates);
std::string time_text(uint64_t nanoseconds);  // "0:00:01.500000000"

}  // namespace weir
