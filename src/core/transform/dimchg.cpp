// mode=dimchg: its grammar and its conversion to a transposition.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/transform/modes.hpp"

#include <algorithm>
#include <numeric>

#include "core/text/text.hpp"
#include "core/transform/option_reader.hpp"

namespace weir::transform {
namespace {

constexpr const char* kDimchgExample = "option=0:2";

Transpose transposition(const Dimchg& dimchg) {
  Transpose out;
  out.order.resize(kRankLimit);
  std::iota(out.order.begin(), out.order.end(), uint8_t{0});
  const auto from = out.order.begin() + dimchg.from, to = out.order.begin() + dimchg.to;
  if (from < to)
    std::rotate(from, from + 1, to + 1);
  else
    std::rotate(to, from, from + 1);
  return out;
}

Result<uint8_t> take_dimension(OptionReader& reader) {
  const size_t begin = reader.position();
  const auto digits = reader.take_digits();
  if (digits.empty() || (digits.size() > 1 && digits[0] == '0')) {
    reader.go_to(begin);
    return reader.syntax_error("the number of a dimension, 0 is the innermost", kDimchgExample);
  }
  const auto value = parse_unsigned(digits);
  if (value && *value < kRankLimit) return static_cast<uint8_t>(*value);
  reader.go_to(begin);
  return reader.value_error("a dimension of the option is out of range",
                            "at most " + std::to_string(kRankLimit - 1), kDimchgExample);
}

}  // namespace

Result<Operation> parse_dimchg(std::string_view option) {
  OptionReader reader("dimchg", option);
  const auto from = take_dimension(reader);
  if (!from) return from.error();
  if (!reader.take(":"))
    return reader.syntax_error("':' and the place it moves to", kDimchgExample);
  const auto to = take_dimension(reader);
  if (!to) return to.error();
  if (!reader.at_end()) return reader.syntax_error("the end", kDimchgExample);
  Operation operation{Dimchg{*from, *to}, {}};
  if (*from == *to)
    operation.warnings.push_back("dimchg " + std::string(option) +
                                 " changes nothing: each frame is passed on as it is");
  return operation;
}

TemplateSpec get_output(const Dimchg& dimchg, const TemplateSpec& in) {
  return get_output(transposition(dimchg), in);
}

std::optional<TemplateSpec> find_input(const Dimchg& dimchg, const TemplateSpec& out) {
  return find_input(transposition(dimchg), out);
}

std::shared_ptr<const Kernel> make_kernel(const Dimchg& dimchg, const TensorSpec& in,
                                          bool accelerate) {
  return make_kernel(transposition(dimchg), in, accelerate);
}

}  // namespace weir::transform
