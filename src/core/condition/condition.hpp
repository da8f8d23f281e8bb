// Condition: the test that tensor_if applies to frames, parsed from its properties; needs no
// stream.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/tensor/shape.hpp"
#include "weir/result.hpp"

namespace weir::condition {

// Numbers as in docs/compatibility/routing.md 6.7.
enum class ComparedValue : int32_t { Element = 0, Average = 3, Custom = 5 };
enum class Operator : int32_t {
  Equal = 0,
  NotEqual,
  Greater,
  GreaterOrEqual,
  Less,
  LessOrEqual,
  InRange,         // V1 <= x <= V2
  InsideRange,     // V1 < x < V2
  NotInRange,      // x < V1 or V2 < x
  NotInsideRange,  // x <= V1 or V2 <= x
};
enum class Behaviour : int32_t { Passthrough = 0, Skip = 1, TensorPick = 7 };

bool needs_two_values(Operator op) noexcept;

// A number of supplied-value; all numbers of one text have the same kind.
struct Number {
  bool is_real = false;
  int64_t whole = 0;
  double real = 0;
};

// The compared element or tensor.
struct Place {
  std::array<uint32_t, kRankLimit> coordinate{};  // 0 where the user gave none
  size_t tensor = 0;
};

struct Condition {
  ComparedValue compared = ComparedValue::Element;
  Operator op = Operator::Equal;
  std::optional<Place> place;    // Element and Average
  std::string callback;          // Custom
  std::vector<Number> supplied;  // at most two
};

// "V" or "V1,V2": int64, or float64 if the text contains one of . e E; "" is an empty list.
// Anything else is an error with its position.
Result<std::vector<Number>> parse_supplied_value(std::string_view text);
// "1:2:3,0": coordinate, innermost first, and tensor index.
Result<Place> parse_element_place(std::string_view text);

// Parses all properties; empty texts leave their fields unset.
Result<Condition> parse_condition(ComparedValue compared, std::string_view compared_option,
                                  Operator op, std::string_view supplied);
// The error for the first required property that is not set.
std::optional<Error> missing(const Condition& condition);

}  // namespace weir::condition
