// mode=arithmetic: its grammar and its type rules.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/transform/modes.hpp"

#include "core/text/text.hpp"
#include "core/transform/chain.hpp"
#include "core/transform/option_reader.hpp"

namespace weir::transform {
namespace {

constexpr const char* kExample = "option=typecast:float32,add:-127.5,div:127.5";

std::optional<Operator> take_operator(OptionReader& reader) noexcept {
  if (reader.take("add:")) return Operator::Add;
  if (reader.take("mul:")) return Operator::Mul;
  if (reader.take("div:")) return Operator::Div;
  return std::nullopt;
}

Result<std::variant<int64_t, double>> take_operand(OptionReader& reader) {
  const size_t begin = reader.position();
  const auto text = reader.take_number();
  if (text.empty()) return reader.syntax_error("a number such as 2, -127.5 or 1e-3", kExample);
  using Value = std::variant<int64_t, double>;
  if (text.find_first_of(".eE") == std::string_view::npos) {
    if (const auto value = parse_signed(text)) return Value(*value);
  } else if (const auto value = parse_double(text)) {
    return Value(*value);
  }
  reader.go_to(begin);
  return reader.value_error("a number of the option is out of range",
                            "a whole number of 64 bits, or a float64 (written with a point)",
                            kExample);
}

// Reads "@12" as 12; nullopt if there is no '@' here.
Result<std::optional<uint32_t>> take_index(OptionReader& reader, const char* meaning,
                                           uint64_t limit) {
  using Index = std::optional<uint32_t>;
  if (!reader.take("@")) return Index{};
  const size_t begin = reader.position();
  const auto digits = reader.take_digits();
  if (digits.empty()) return reader.syntax_error(std::string(meaning) + " after '@'", kExample);
  const auto value = parse_unsigned(digits);
  if (value && *value <= limit) return Index{static_cast<uint32_t>(*value)};
  reader.go_to(begin);
  return reader.value_error(std::string(meaning) + " of the option is out of range",
                            "at most " + std::to_string(limit),
                            "option=per-channel:true@0,add:-127.5@0");
}

Result<ArithmeticStep> take_step(OptionReader& reader) {
  const auto op = take_operator(reader);
  if (!op) return reader.syntax_error("add:NUMBER, mul:NUMBER or div:NUMBER", kExample);
  auto operand = take_operand(reader);
  if (!operand) return std::move(operand).error();
  while (reader.take(":")) {  // "add:1:2:3": only the first number is used
    auto ignored = take_operand(reader);
    if (!ignored) return std::move(ignored).error();
  }
  auto channel = take_index(reader, "a channel", UINT32_MAX);
  if (!channel) return std::move(channel).error();
  return ArithmeticStep{*op, *operand, *channel};
}

// Handles a typecast in place of an operator. At the very end it is ignored with a warning, for
// compatibility.
Status take_late_typecast(OptionReader& reader, const Arithmetic& arithmetic,
                          std::vector<std::string>& warnings) {
  const size_t begin = reader.position();
  if (!reader.take("typecast:")) return ok();
  const auto type = reader.take_type();
  if (type == ElementType::End)
    return reader.syntax_error("an element type such as float32", kExample);
  if (reader.at_end() && !arithmetic.steps.empty()) {
    warnings.emplace_back(
        "typecast comes first in an arithmetic option; the one at the end is ignored");
    return ok();
  }
  std::string fix = "option=typecast:" + std::string(to_string(type)) + ",";
  fix += reader.text().substr(0, begin);
  reader.take(",");
  fix += reader.text().substr(reader.position());
  reader.go_to(begin);
  return reader.syntax_error("typecast only at the start of the option", std::move(fix));
}

Status take_typecast(OptionReader& reader, Arithmetic& arithmetic) {
  if (!reader.take("typecast:")) return ok();
  arithmetic.to = reader.take_type();
  if (arithmetic.to == ElementType::End)
    return reader.syntax_error("an element type such as float32", kExample);
  if (!reader.take(",")) return reader.syntax_error("',' and an operator", kExample);
  return ok();
}

Status take_per_channel(OptionReader& reader, Arithmetic& arithmetic) {
  constexpr const char* kFix = "option=per-channel:true@0,add:-123@0,add:-117@1,add:-104@2";
  if (!reader.take("per-channel:")) return ok();
  if (reader.take("true")) {
    auto dimension = take_index(reader, "a dimension", kRankLimit - 1);
    if (!dimension) return std::move(dimension).error();
    if (!*dimension) return reader.syntax_error("'@' and a dimension, 0 is the innermost", kFix);
    arithmetic.channel_dimension = **dimension;
  } else if (!reader.take("false")) {
    return reader.syntax_error("true@DIMENSION or false", kFix);
  }
  if (!reader.take(",")) return reader.syntax_error("',' and an operator", kFix);
  return ok();
}

Status take_steps(OptionReader& reader, Arithmetic& arithmetic,
                  std::vector<std::string>& warnings) {
  if (auto late = take_late_typecast(reader, arithmetic, warnings); !late) return late;
  do {
    auto step = take_step(reader);
    if (!step) return std::move(step).error();
    arithmetic.steps.push_back(*step);
    reader.take(",");  // optional, also at the end
    if (auto late = take_late_typecast(reader, arithmetic, warnings); !late) return late;
  } while (!reader.at_end());
  return ok();
}

ElementType type_after(const Arithmetic& arithmetic, ElementType in) noexcept {
  return arithmetic.to == ElementType::End ? in : arithmetic.to;
}

}  // namespace

Result<Operation> parse_arithmetic(std::string_view option) {
  OptionReader reader("arithmetic", option);
  Operation operation;
  Arithmetic arithmetic;
  if (auto status = take_typecast(reader, arithmetic); !status) return std::move(status).error();
  if (auto status = take_per_channel(reader, arithmetic); !status) return std::move(status).error();
  if (auto status = take_steps(reader, arithmetic, operation.warnings); !status)
    return std::move(status).error();
  operation.what = std::move(arithmetic);
  return operation;
}

TemplateSpec get_output(const Arithmetic& arithmetic, const TemplateSpec& in) {
  return {type_after(arithmetic, in.type), in.shape};
}

std::optional<TemplateSpec> find_input(const Arithmetic& arithmetic, const TemplateSpec& out) {
  if (arithmetic.to == ElementType::End) return out;
  if (!out.type_open() && out.type != arithmetic.to) return std::nullopt;
  return TemplateSpec{ElementType::End, out.shape};
}

std::shared_ptr<const Kernel> make_kernel(const Arithmetic& arithmetic, const TensorSpec& in,
                                          bool accelerate) {
  return make_chain_kernel(in, type_after(arithmetic, in.type), arithmetic.steps,
                           arithmetic.channel_dimension, accelerate);
}

}  // namespace weir::transform
