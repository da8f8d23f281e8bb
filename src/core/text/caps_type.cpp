// The names of types, and which text is a value of one.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/text/caps_type.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

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

}  // namespace weir
