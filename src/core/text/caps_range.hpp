// Ranges of numbers in the text of caps.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
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

}  // namespace weir
