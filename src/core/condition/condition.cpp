// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/condition/condition.hpp"

#include <algorithm>

#include "core/split/pick_list.hpp"
#include "core/text/error_text.hpp"
#include "core/text/text.hpp"

namespace weir::condition {
namespace {

Error unreadable(const char* property, std::string_view text, std::string_view part,
                 const char* needed, const char* example) {
  return Error{.code = Code::OPTION_SYNTAX,
               .what = std::string(property) + " cannot be read",
               .offered = std::string(property) + "=" + std::string(text),
               .needed = needed,
               .difference = place_in(text, static_cast<size_t>(part.data() - text.data())),
               .fix = std::string(property) + "=" + example};
}

// Strips blanks; for a blank part, returns its position.
std::string_view trimmed(std::string_view part) {
  const auto inner = strip(part);
  return inner.empty() ? part.substr(0, 0) : inner;
}

}  // namespace

bool needs_two_values(Operator op) noexcept {
  return op >= Operator::InRange;
}

Result<std::vector<Number>> parse_supplied_value(std::string_view text) {
  constexpr char kNeeded[] = "one number, or two separated by ','; integers must fit into int64";
  std::vector<Number> out;
  if (strip(text).empty()) return out;
  const bool real = text.find_first_of(".eE") != std::string_view::npos;
  for (const auto raw : split(text, ",")) {
    const auto part = trimmed(raw);
    const auto whole = real ? std::nullopt : parse_signed(part);
    const auto value = real ? parse_double(part) : std::nullopt;
    if ((!whole && !value) || out.size() == 2)
      return unreadable("supplied-value", text, part, kNeeded, "10,100");
    out.push_back({real, whole.value_or(0), value.value_or(0)});
  }
  return out;
}

Result<Place> parse_element_place(std::string_view text) {
  constexpr char kNeeded[] = "a coordinate, innermost first, then ',' and the index of the tensor";
  constexpr char kExample[] = "0:0:0:0,0";
  const auto halves = split(text, ",");
  if (halves.size() != 2)
    return unreadable("compared-value-option", text,
                      halves.size() < 2 ? text.substr(text.size()) : halves[2], kNeeded, kExample);
  Place place;
  size_t rank = 0;
  if (!strip(halves[0]).empty())
    for (const auto raw : split(halves[0], ":")) {
      const auto part = trimmed(raw);
      const auto index = parse_unsigned(part);
      if (!index || *index > UINT32_MAX || rank == kRankLimit)
        return unreadable("compared-value-option", text, part, kNeeded, kExample);
      place.coordinate[rank++] = static_cast<uint32_t>(*index);
    }
  const auto tensor = parse_unsigned(trimmed(halves[1]));
  if (!tensor)
    return unreadable("compared-value-option", text, trimmed(halves[1]), kNeeded, kExample);
  place.tensor = static_cast<size_t>(*tensor);
  return place;
}

Result<Condition> parse_condition(ComparedValue compared, std::string_view compared_option,
                                  Operator op, std::string_view supplied) {
  Condition condition;
  condition.compared = compared;
  condition.op = op;
  auto numbers = parse_supplied_value(supplied);
  if (!numbers) return numbers.error();
  condition.supplied = *std::move(numbers);
  const auto option = strip(compared_option);
  if (option.empty()) return condition;
  if (compared == ComparedValue::Custom) {
    condition.callback = option;
  } else if (compared == ComparedValue::Element) {
    auto place = parse_element_place(compared_option);
    if (!place) return place.error();
    condition.place = *place;
  } else {
    const auto tensor = parse_unsigned(option);
    if (!tensor)
      return unreadable("compared-value-option", compared_option, option,
                        "the index of the tensor whose average is compared", "0");
    condition.place = Place{{}, static_cast<size_t>(*tensor)};
  }
  return condition;
}

std::optional<Error> missing(const Condition& condition) {
  const bool custom = condition.compared == ComparedValue::Custom;
  if (custom ? condition.callback.empty() : !condition.place)
    return Error{
        .code = Code::OPTION_VALUE,
        .what = "tensor_if needs to know what to compare",
        .offered = "no compared-value-option",
        .needed = custom ? "the name of a registered function"
                         : "the coordinates of an element, or the index of a tensor to average",
        .fix = custom ? "compared-value=CUSTOM compared-value-option=NAME"
                      : "compared-value=A_VALUE compared-value-option=0:0:0:0,0"};
  const size_t needed = needs_two_values(condition.op) ? 2 : 1;
  if (custom || condition.supplied.size() >= needed) return std::nullopt;
  return Error{.code = Code::OPTION_VALUE,
               .what = "tensor_if needs to know what to compare with",
               .offered = std::to_string(condition.supplied.size()) + " numbers in supplied-value",
               .needed = std::to_string(needed),
               .fix = needed == 2 ? "supplied-value=10,100" : "supplied-value=10"};
}

}  // namespace weir::condition
