// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/text/caps_type.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>

#include "core/text/text.hpp"

namespace weir {
namespace {

struct NamedCapsType {
  std::string_view name;
  CapsType type;
};
// The abbreviations and names that GStreamer knows.
constexpr NamedCapsType kCapsTypes[] = {
    {"int", CapsType::Int},
    {"i", CapsType::Int},
    {"gint", CapsType::Int},
    {"int64", CapsType::Int64},
    {"gint64", CapsType::Int64},
    {"double", CapsType::Double},
    {"d", CapsType::Double},
    {"gdouble", CapsType::Double},
    {"fraction", CapsType::Fraction},
    {"GstFraction", CapsType::Fraction},
    {"buffer", CapsType::Buffer},
    {"GstBuffer", CapsType::Buffer},
    {"list", CapsType::List},
    {"GstValueList", CapsType::List},
    {"array", CapsType::List},
    {"GstValueArray", CapsType::List},
    {"structure", CapsType::Structure},
    {"GstStructure", CapsType::Structure},
    {"GstCaps", CapsType::Caps},
    {"uint", CapsType::Uint},
    {"u", CapsType::Uint},
    {"guint", CapsType::Uint},
    {"uint64", CapsType::Uint64},
    {"guint64", CapsType::Uint64},
    {"float", CapsType::Float},
    {"f", CapsType::Float},
    {"gfloat", CapsType::Float},
    {"boolean", CapsType::Boolean},
    {"bool", CapsType::Boolean},
    {"b", CapsType::Boolean},
    {"gboolean", CapsType::Boolean},
    {"string", CapsType::Text},
    {"str", CapsType::Text},
    {"s", CapsType::Text},
    {"gchararray", CapsType::Text},
    {"bitmask", CapsType::Bitmask},
    {"GstBitmask", CapsType::Bitmask},
    {"flagset", CapsType::Plain},
    {"GstFlagSet", CapsType::Plain},
};

std::optional<int64_t> range_integer(std::string_view text, int64_t min, int64_t max) {
  if (equal_ignoring_case(text, "min")) return min;
  if (equal_ignoring_case(text, "max")) return max;
  const auto number = parse_signed(text);
  return number && *number >= min && *number <= max ? number : std::nullopt;
}

template <class Int>
bool is_integer_range(std::string_view first, std::string_view last, std::string_view step) {
  constexpr int64_t kMin = std::numeric_limits<Int>::min(), kMax = std::numeric_limits<Int>::max();
  const auto a = range_integer(first, kMin, kMax), b = range_integer(last, kMin, kMax);
  if (!a || !b || *a >= *b) return false;
  if (step.empty()) return true;
  const auto s = range_integer(step, 1, kMax);
  return s && *a % *s == 0 && *b % *s == 0;
}

bool is_double_range(std::string_view first, std::string_view last) {
  const auto a = parse_double(first), b = parse_double(last);
  return a && b && *a < *b;
}

struct RangeRatio {
  int64_t numerator, denominator;
};
std::optional<RangeRatio> range_ratio(std::string_view text) {
  constexpr int64_t kMax = std::numeric_limits<int32_t>::max();
  const size_t slash = std::min(text.find('/'), text.size());
  const auto numerator = parse_signed(text.substr(0, slash));
  const auto denominator =
      slash == text.size() ? std::optional<int64_t>(1) : parse_signed(text.substr(slash + 1));
  if (!numerator || !denominator || *numerator < -kMax || *numerator > kMax || *denominator < 1 ||
      *denominator > kMax)
    return std::nullopt;
  return RangeRatio{*numerator, *denominator};
}

bool is_fraction_range(std::string_view first, std::string_view last) {
  const auto a = range_ratio(first), b = range_ratio(last);
  return a && b && a->numerator * b->denominator < b->numerator * a->denominator;
}

}  // namespace

std::optional<CapsType> caps_type(std::string_view name) {
  const auto* found = std::find_if(std::begin(kCapsTypes), std::end(kCapsTypes),
                                   [name](const NamedCapsType& t) { return t.name == name; });
  return found == std::end(kCapsTypes) ? std::nullopt : std::optional(found->type);
}

RangeType range_type(CapsType type) {
  switch (type) {
    case CapsType::Int:
      return RangeType::Int;
    case CapsType::Int64:
      return RangeType::Int64;
    case CapsType::Double:
      return RangeType::Double;
    case CapsType::Fraction:
      return RangeType::Fraction;
    default:
      return RangeType::Guessed;
  }
}

bool is_value(CapsType type, std::string_view text) {
  switch (type) {
    case CapsType::Guessed:
    case CapsType::Text:
    case CapsType::Buffer:
      return true;  // checked before
    case CapsType::Int:
      return is_number(RangeType::Int, text);
    case CapsType::Int64:
      return is_number(RangeType::Int64, text);
    case CapsType::Double:
      return is_number(RangeType::Double, text);
    case CapsType::Fraction:
      return is_number(RangeType::Fraction, text);
    case CapsType::Uint:
      return parse_unsigned(text).value_or(UINT64_MAX) <= UINT32_MAX;
    case CapsType::Uint64:
      return parse_unsigned(text).has_value();
    case CapsType::Float: {
      const auto number = parse_double(text);
      return number && std::abs(*number) <= std::numeric_limits<float>::max();
    }
    case CapsType::Boolean:
      return text == "true" || text == "false";
    case CapsType::Bitmask:
      return text.size() > 2 && text.size() <= 18 && text.starts_with("0x") &&
             std::all_of(text.begin() + 2, text.end(), is_caps_hex_digit);
    default:
      return false;
  }
}

bool is_number(RangeType type, std::string_view text) {
  switch (type) {
    case RangeType::Int:
      return range_integer(text, INT32_MIN, INT32_MAX).has_value();
    case RangeType::Int64:
      return range_integer(text, INT64_MIN, INT64_MAX).has_value();
    case RangeType::Double:
      return parse_double(text).has_value();
    case RangeType::Fraction:
      return range_ratio(text).has_value();
    case RangeType::Guessed:
      break;
  }
  return true;
}

bool is_range(RangeType type, std::string_view first, std::string_view last,
              std::string_view step) {
  switch (type) {
    case RangeType::Int:
      return is_integer_range<int32_t>(first, last, step);
    case RangeType::Int64:
      return is_integer_range<int64_t>(first, last, step);
    case RangeType::Double:
      return step.empty() && is_double_range(first, last);
    case RangeType::Fraction:
      return step.empty() && is_fraction_range(first, last);
    case RangeType::Guessed:
      break;
  }
  if (is_number(RangeType::Int, first) && is_number(RangeType::Int, last))
    return is_range(RangeType::Int, first, last, step);
  if (is_number(RangeType::Int, first) || is_number(RangeType::Int, last)) return false;
  return is_range(RangeType::Double, first, last, step) ||
         is_range(RangeType::Fraction, first, last, step);
}

}  // namespace weir
