// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/filter/model_description.hpp"

#include <algorithm>
#include <span>

#include "core/filter/layout_list.hpp"
#include "weir/join.hpp"

namespace weir {
namespace {

void set_names(const std::string& names, std::vector<ModelTensor>* shapes) {
  const auto list = parse_name_list(names);
  for (size_t i = 0; i < std::min(list.size(), shapes->size()); ++i)
    if (!list[i].empty()) (*shapes)[i].name = list[i];
}

std::string format_list(const std::vector<ModelTensor>& shapes,
                        std::string (*text)(const ModelTensor&)) {
  return join(shapes, ",", text);
}

// Innermost first; open dimensions are 1; empty if the rank is unknown.
std::string format_dimensions(const ModelTensor& shape) {
  if (shape.shape.empty()) return shape.rank_known ? "1" : "";
  std::string out;
  for (size_t i = shape.shape.size(); i-- > 0;)
    out += (out.empty() ? "" : ":") + std::to_string(std::max<int64_t>(shape.shape[i], 1));
  return out;
}

}  // namespace

Result<ModelDescription> describe_model(ModelTensors model, const DeclaredTensors& declared,
                                        std::vector<Error>* warnings) {
  auto inputs =
      with_user_settings(std::move(model.inputs), declared.input, declared.inputtype, "input");
  if (!inputs) return inputs.error();
  auto outputs =
      with_user_settings(std::move(model.outputs), declared.output, declared.outputtype, "output");
  if (!outputs) return outputs.error();
  auto input_choice = parse_input_combination(declared.input_combination);
  if (!input_choice) return input_choice.error();
  auto output_choice = parse_output_combination(declared.output_combination);
  if (!output_choice) return output_choice.error();
  ModelDescription out{{*std::move(inputs), *std::move(outputs)},
                       *std::move(input_choice),
                       *std::move(output_choice),
                       declared};
  set_names(declared.inputname, &out.inputs);
  set_names(declared.outputname, &out.outputs);
  std::optional<Error> of_inputs, of_outputs;
  set_layouts(parse_layout_list(declared.inputlayout, "inputlayout", &of_inputs), &out.inputs);
  set_layouts(parse_layout_list(declared.outputlayout, "outputlayout", &of_outputs), &out.outputs);
  for (const auto& warning : {of_inputs, of_outputs})
    if (warning) warnings->push_back(*warning);
  if (!out.outputs.empty())
    if (auto status = out.check_output_choice(out.outputs); !status) return status.error();
  return out;
}

Status ModelDescription::check_output_choice(const std::vector<ModelTensor>& of) const {
  for (const size_t index : output_choice.outputs)
    if (index >= of.size())
      return Error{.code = Code::OPTION_VALUE,
                   .what = "output-combination names an output that the model lacks",
                   .offered = "o" + std::to_string(index),
                   .needed = std::to_string(of.size()) + " outputs, from o0 on",
                   .fix = "output-combination=o0"};
  return ok();
}

Result<std::vector<ModelTensor>> ModelDescription::complete_outputs(
    std::vector<ModelTensor> resolved) const {
  if (resolved.size() != outputs.size() && !resolved.empty() && !outputs.empty())
    return Error{.code = Code::SPEC_MISMATCH,
                 .what = "output= and the model's outputs for this stream differ in number",
                 .offered = list_tensors(outputs),
                 .needed = list_tensors(resolved),
                 .difference = "number of tensors",
                 .fix = "omit output and outputtype: the model declares them"};
  if (resolved.empty()) {
    resolved = outputs;
  } else {
    auto agreed =
        with_user_settings(std::move(resolved), declared.output, declared.outputtype, "output");
    if (!agreed) return agreed.error();
    resolved = *std::move(agreed);
  }
  if (resolved.empty())
    return Error{.code = Code::MODEL_UNSUPPORTED,
                 .what = "the model declares no outputs for this stream",
                 .needed = "at least one",
                 .fix = "tensor_filter output=... outputtype=..."};
  for (size_t i = 0; i < std::min(resolved.size(), outputs.size()); ++i) {
    if (!resolved[i].fixed() && outputs[i].fixed()) resolved[i] = outputs[i];
    if (resolved[i].name.empty()) resolved[i].name = outputs[i].name;
    resolved[i].layout = outputs[i].layout;
  }
  if (auto status = check_output_choice(resolved); !status) return status.error();
  return resolved;
}

FrameSpec ModelDescription::sink_spec() const {
  FrameSpec spec{Format::Static, {}, {}};
  if (input_choice.empty()) spec.tensors = known_parts(inputs);
  return spec;
}

FrameSpec ModelDescription::source_spec() const {
  FrameSpec spec{declared.invoke_dynamic ? Format::Flexible : Format::Static, {}, {}};
  if (output_choice.inputs.empty()) spec.tensors = chosen_outputs(outputs);
  return spec;
}

Result<FrameSpec> ModelDescription::source_spec(const FrameSpec& sink,
                                                const std::vector<ModelTensor>& of,
                                                bool sizes_known) const {
  const bool flexible = declared.invoke_dynamic || !sizes_known;
  FrameSpec spec{flexible ? Format::Flexible : Format::Static, {}, sink.rate};
  if (flexible) return spec;
  if (!output_choice.inputs.empty()) {
    auto passed = choose_tensors(sink.tensors, output_choice.inputs, "output-combination");
    if (!passed) return passed.error();
    spec.tensors = *std::move(passed);
  }
  const auto results = chosen_outputs(of);
  spec.tensors.insert(spec.tensors.end(), results.begin(), results.end());
  return spec;
}

std::vector<TensorSpec> ModelDescription::chosen_outputs(const std::vector<ModelTensor>& of) const {
  auto all = known_parts(of);
  if (output_choice.empty()) return all;
  std::vector<TensorSpec> chosen;
  for (const size_t index : output_choice.outputs)
    if (index < all.size()) chosen.push_back(all[index]);  // a model may not say how many it has
  return chosen;
}

bool all_fixed(const std::vector<ModelTensor>& shapes) {
  return !shapes.empty() &&
         std::all_of(shapes.begin(), shapes.end(), [](const auto& shape) { return shape.fixed(); });
}

std::string dimensions_text(const std::vector<ModelTensor>& shapes) {
  return format_list(shapes, format_dimensions);
}
std::string types_text(const std::vector<ModelTensor>& shapes) {
  return join_types(known_parts(shapes));
}
std::string names_text(const std::vector<ModelTensor>& shapes) {
  return join_names(known_parts(shapes));
}
std::string layouts_text(const std::vector<ModelTensor>& shapes) {
  std::vector<uint32_t> layouts;
  layouts.reserve(shapes.size());
  for (const auto& shape : shapes) layouts.push_back(shape.layout);
  return layouts_text(std::span<const uint32_t>(layouts));
}
std::string ranks_text(const std::vector<ModelTensor>& shapes) {
  return format_list(shapes, [](const ModelTensor& shape) {
    return std::to_string(std::max<size_t>(shape.shape.size(), 1));
  });
}

}  // namespace weir
