// mode=typecast.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/transform/modes.hpp"

#include <array>

#include "core/text/text.hpp"
#include "core/transform/chain.hpp"
#include "core/transform/option_reader.hpp"

namespace weir::transform {
namespace {

std::vector<std::string> type_names() {
  std::vector<std::string> names;
  for (uint32_t i = 0; i < static_cast<uint32_t>(ElementType::End); ++i)
    names.emplace_back(to_string(static_cast<ElementType>(i)));
  return names;
}

}  // namespace

Result<Operation> parse_typecast(std::string_view option) {
  if (const auto type = parse_element_type(strip(option)); type != ElementType::End)
    return Operation{Typecast{type}, {}};
  OptionReader reader("typecast", option);
  reader.take_type();  // the error refers to the text after it
  const auto names = type_names();
  const auto near = nearest(option, names);
  return reader.syntax_error(
      "one of int8, uint8, int16, uint16, int32, uint32, int64, uint64, float16, float32, float64",
      "option=" + (near.empty() ? "float32" : near));
}

TemplateSpec get_output(const Typecast& typecast, const TemplateSpec& in) {
  return {typecast.to, in.shape};
}

std::optional<TemplateSpec> find_input(const Typecast& typecast, const TemplateSpec& out) {
  if (!out.type_open() && out.type != typecast.to) return std::nullopt;
  return TemplateSpec{ElementType::End, out.shape};
}

std::shared_ptr<const Kernel> make_kernel(const Typecast& typecast, const TensorSpec& in,
                                          bool accelerate) {
  return make_chain_kernel(in, typecast.to, {}, std::nullopt, accelerate);
}

}  // namespace weir::transform
