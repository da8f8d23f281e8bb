// Opening a model from the element's settings, and planning for caps.
#include "elements/tensor_filter/opened_model.hpp"

#include <algorithm>

#include "core/infer/module_library.hpp"
#include "core/text/text.hpp"
#include "elements/tensor_filter/model_info.hpp"

namespace weir {
namespace {

std::vector<std::string> paths_of(const std::string& model) {
  std::vector<std::string> out;
  for (const auto part : split(model, ",")) {
    const auto path = strip(part);
    if (!path.empty()) out.emplace_back(path);
  }
  return out;
}

Result<const weir_engine*> engine_for(const FilterSettings& s,
                                      const std::vector<std::string>& paths) {
  auto& library = infer::ModuleLibrary::instance();
  const bool automatic = s.framework.empty() || equal_ignoring_case(s.framework, "auto") ||
                         equal_ignoring_case(s.framework, "any");
  return automatic ? library.engine_for_model(paths) : library.engine(s.framework);
}

// "NumThreads:2,Delegate:XNNPACK" -> options of the engine.
std::vector<std::pair<std::string, std::string>> options_of(const std::string& custom) {
  std::vector<std::pair<std::string, std::string>> out;
  for (const auto part : split(custom, ",")) {
    const auto text = strip(part);
    if (text.empty()) continue;
    const size_t colon = text.find(':');
    const auto value =
        colon == std::string_view::npos ? std::string_view{} : text.substr(colon + 1);
    out.emplace_back(strip(text.substr(0, colon)), strip(value));
  }
  return out;
}

void set_names(const std::string& names, std::vector<ModelShape>* shapes) {
  const auto list = parse_name_list(names);
  for (size_t i = 0; i < std::min(list.size(), shapes->size()); ++i)
    if (!list[i].empty()) (*shapes)[i].name = list[i];
}

}  // namespace

Result<std::unique_ptr<OpenedModel>> OpenedModel::open(const FilterSettings& s) {
  const auto paths = paths_of(s.model);
  if (paths.empty())
    return Error{Code::MODEL_NOT_FOUND,
                 "no model is set",
                 "model=\"\"",
                 "the path of a model file",
                 "",
                 "tensor_filter model=mobilenet.tflite"};
  const auto engine = engine_for(s, paths);
  if (!engine) return engine.error();
  auto opened = std::make_unique<OpenedModel>();
  opened->engine_ = (*engine)->name;
  infer::OpenOptions options;
  options.paths = paths;
  options.options = options_of(s.custom);
  auto model = infer::Model::open(**engine, options);
  if (!model) return model.error();
  opened->model_ = *std::move(model);
  auto session = infer::Session::create(opened->model_);
  if (!session) return session.error();
  opened->session_ = *std::move(session);

  auto inputs =
      with_user_settings(model_shapes(opened->model_->inputs()), s.input, s.inputtype, "input");
  if (!inputs) return inputs.error();
  auto outputs =
      with_user_settings(model_shapes(opened->model_->outputs()), s.output, s.outputtype, "output");
  if (!outputs) return outputs.error();
  opened->inputs_ = *std::move(inputs);
  opened->outputs_ = *std::move(outputs);
  set_names(s.inputname, &opened->inputs_);
  set_names(s.outputname, &opened->outputs_);
  if (auto status = opened->read_combinations(s); !status) return status.error();
  return opened;
}

Status OpenedModel::read_combinations(const FilterSettings& s) {
  auto input = parse_input_combination(s.input_combination);
  if (!input) return input.error();
  auto output = parse_output_combination(s.output_combination);
  if (!output) return output.error();
  for (const size_t index : output->outputs)
    if (index >= outputs_.size())
      return Error{Code::OPTION_VALUE,
                   "output-combination names an output that the model lacks",
                   "o" + std::to_string(index),
                   std::to_string(outputs_.size()) + " outputs, from o0 on",
                   "",
                   "output-combination=o0"};
  input_choice_ = *std::move(input);
  output_choice_ = *std::move(output);
  return ok();
}

std::vector<TensorSpec> OpenedModel::known_outputs() const {
  if (!output_choice_.inputs.empty()) return {};
  const auto all = known_parts(outputs_);
  if (output_choice_.empty()) return all;
  std::vector<TensorSpec> chosen;
  for (const size_t index : output_choice_.outputs) chosen.push_back(all[index]);
  return chosen;
}

gst::Allocation OpenedModel::allocation() const noexcept {
  gst::Allocation out;
  out.alignment = std::max<size_t>(out.alignment, model_->info().alignment);
  out.padding = model_->info().input_padding;
  return out;
}

Result<FilterPlan> OpenedModel::plan_for(const FrameSpec& input) const {
  FilterPlan plan;
  plan.alignment = model_->info().alignment;
  plan.padding = model_->info().input_padding;
  plan.input = input;
  plan.input_choice = input_choice_;
  plan.output_choice = output_choice_;
  plan.declared_inputs = inputs_;
  plan.model_inputs = inputs_;
  plan.model_outputs = outputs_;
  if (input.format == Format::Static) {
    auto chosen = choose_tensors(input.tensors, input_choice_, "input-combination");
    if (!chosen) return chosen.error();
    auto fitted = fit(inputs_, *chosen);
    if (!fitted) return fitted.error();
    plan.model_inputs = *std::move(fitted);
    auto outputs = resolve(session_.get(), plan.model_inputs, outputs_);
    if (!outputs) return outputs.error();
    plan.model_outputs = *std::move(outputs);
  }
  const auto fixed = [](const auto& shape) { return shape.fixed(); };
  plan.outputs_fixed = std::all_of(plan.model_outputs.begin(), plan.model_outputs.end(), fixed) &&
                       std::all_of(plan.model_inputs.begin(), plan.model_inputs.end(), fixed);
  plan.output.rate = input.rate;
  plan.output.format = plan.outputs_fixed ? Format::Static : Format::Flexible;
  if (!plan.outputs_fixed) return plan;
  auto images = choose_tensors(input.tensors, output_choice_.inputs, "output-combination");
  if (!images) return images.error();
  if (!output_choice_.inputs.empty()) plan.output.tensors = *std::move(images);
  const auto all = known_parts(plan.model_outputs);
  for (size_t i = 0; i < all.size(); ++i)
    if (output_choice_.empty() ||
        std::find(output_choice_.outputs.begin(), output_choice_.outputs.end(), i) !=
            output_choice_.outputs.end())
      plan.output.tensors.push_back(all[i]);
  return plan;
}

}  // namespace weir
