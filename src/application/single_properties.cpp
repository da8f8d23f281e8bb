// The properties of a Single.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <utility>
#include <vector>

#include "core/text/error_text.hpp"
#include "core/text/text.hpp"
#include "single.hpp"
#include "weir/join.hpp"

namespace weir::application {
namespace {

Error wrong_number(const std::string& value, const TensorSpecs& needed) {
  return Error{.code = Code::SPEC_MISMATCH,
               .what = "the number of values differs from the number of inputs of the model",
               .offered = value,
               .needed = std::to_string(needed.size()) + ": " + describe(needed),
               .difference = "number of tensors"};
}

// Writes each value of a list into the input of its index.
template <class T, class Write>
Status write_each(const Result<std::vector<T>>& list, const std::string& value,
                  TensorSpecs* tensors, Write&& write) {
  if (!list) return list.error();
  if (list->size() != tensors->size()) return wrong_number(value, *tensors);
  for (size_t i = 0; i < tensors->size(); ++i) write((*tensors)[i], (*list)[i]);
  return ok();
}

Status read_inputs(const std::string& name, const std::string& value, TensorSpecs* tensors) {
  if (name == "input")
    return write_each(parse_shape_list(value), value, tensors,
                      [](TensorSpec& tensor, const Shape& shape) { tensor.shape = shape; });
  if (name == "inputtype")
    return write_each(parse_type_list(value), value, tensors,
                      [](TensorSpec& tensor, ElementType type) { tensor.type = type; });
  return write_each(Result<std::vector<std::string>>(parse_name_list(value)), value, tensors,
                    [](TensorSpec& tensor, const std::string& word) { tensor.name = word; });
}

std::string layouts(const TensorSpecs& tensors) {
  return join(tensors, ",", [](const TensorSpec&) { return std::string("ANY"); });
}

}  // namespace

Single::Outcome<std::string> Single::property(const std::string& name) const {
  const std::pair<const char*, std::string> all[]{{"input", join_shapes(inputs())},
                                                  {"inputtype", join_types(inputs())},
                                                  {"inputname", join_names(inputs())},
                                                  {"inputlayout", layouts(inputs())},
                                                  {"output", join_shapes(outputs())},
                                                  {"outputtype", join_types(outputs())},
                                                  {"outputname", join_names(outputs())},
                                                  {"outputlayout", layouts(outputs())},
                                                  {"accelerator", "true:" + request_.accelerator},
                                                  {"custom", request_.custom},
                                                  {"is-updatable", "false"},
                                                  {"framework", request_.framework},
                                                  {"model", request_.model}};
  std::vector<std::string> names;
  for (const auto& [known_name, value] : all) {
    if (name == known_name) return value;
    names.emplace_back(known_name);
  }
  return Refusal{ML_ERROR_NOT_SUPPORTED, not_one_of("no property has this name", name, names)};
}

Single::Outcome<Single::Done> Single::set_property(const std::string& name,
                                                   const std::string& value) {
  auto now = property(name);
  if (auto* refused = std::get_if<Refusal>(&now)) return std::move(*refused);
  if (equal_ignoring_case(std::get<std::string>(now), value)) return Done();
  if (name == "is-updatable" && !equal_ignoring_case(value, "true"))
    return refusal(Error{.code = Code::OPTION_VALUE,
                         .what = "is-updatable is not a boolean",
                         .offered = value,
                         .needed = "true or false"});
  if (name != "input" && name != "inputtype" && name != "inputname") return Done();
  TensorSpecs wanted = inputs();
  if (auto status = read_inputs(name, value, &wanted); !status) return refusal(status.error());
  return set_inputs(wanted);
}

}  // namespace weir::application
