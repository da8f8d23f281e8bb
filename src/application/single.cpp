// Single: uses weir/model.h; reverses dimensions, and ignores differences in trailing 1s.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "single.hpp"

#include <array>
#include <filesystem>
#include <optional>
#include <utility>

#include "core/infer/module/custom_options.hpp"
#include "core/text/text.hpp"
#include "weir/c_error.hpp"
#include "weir/join.hpp"

namespace weir::application {
namespace {

using Pairs = std::vector<std::pair<std::string, std::string>>;
using Describe = int (*)(const weir_loaded_model*, uint32_t, weir_tensor_info*);

std::vector<weir_tensor_info> get_infos(const weir_loaded_model* model, uint32_t count,
                                        Describe describe) {
  std::vector<weir_tensor_info> out(count);
  for (uint32_t i = 0; i < count; ++i) describe(model, i, &out[i]);
  return out;
}

TensorSpecs to_specs(const std::vector<weir_tensor_info>& infos) {
  TensorSpecs out;
  for (const auto& info : infos) out.push_back(to_spec(info));
  return out;
}

bool known(const weir_tensor_info& info) {
  if (info.rank > WEIR_RANK_LIMIT || info.type >= WEIR_TYPE_END) return false;
  for (uint32_t i = 0; i < info.rank; ++i)
    if (info.shape[i] < 1) return false;
  return true;
}

// Returns the description of `spec` with the model's rank, if only 1s are added or removed.
weir_tensor_info with_rank(const TensorSpec& spec, const weir_tensor_info& model) {
  weir_tensor_info info = c_info(spec);
  if (model.rank > WEIR_RANK_LIMIT || spec.shape.min_rank() > model.rank) return info;
  for (uint32_t i = 0; i < model.rank; ++i)
    info.shape[i] = std::max<int64_t>(1, spec.shape[model.rank - 1 - i]);
  info.rank = model.rank;
  return info;
}

void declare(const char* prefix, const TensorSpecs& tensors, Pairs* out) {
  if (tensors.empty()) return;
  out->emplace_back(prefix, join_shapes(tensors));
  out->emplace_back(std::string(prefix) + "type", join_types(tensors));
  const std::string names = join_names(tensors);
  if (names.find_first_not_of(',') != std::string::npos)
    out->emplace_back(std::string(prefix) + "name", names);
}

std::vector<weir_option> c_options(const Pairs& pairs) {
  std::vector<weir_option> out;
  for (const auto& [key, value] : pairs) out.push_back({key.c_str(), value.c_str()});
  return out;
}

// Returns the engine's name; nullopt: invalid number; "": chosen by the model file. `model` selects
// among the custom engines.
std::optional<std::string> framework_name(ml_nnfw_type_e type, const std::string& model) {
  constexpr std::array kNames{"",
                              "custom-easy",
                              "tensorflow-lite",
                              "tensorflow",
                              "nnfw",
                              "movidius-ncsdk2",
                              "openvino",
                              "vivante",
                              "edgetpu",
                              "armnn",
                              "snpe",
                              "pytorch",
                              "trix-engine",
                              "tvm",
                              "onnxruntime",
                              "ncnn",
                              "tensorrt",
                              "executorch"};
  static_assert(kNames.size() == ML_NNFW_TYPE_EXECUTORCH + 1);
  const auto number = static_cast<size_t>(type);
  if (number >= kNames.size()) return std::nullopt;
  std::error_code ignored;
  if (type == ML_NNFW_TYPE_CUSTOM_FILTER && std::filesystem::is_regular_file(model, ignored))
    return "custom";
  return kNames[number];
}

// Returns for example "cpu" or "npu.edgetpu"; "": the engine's choice; nullopt: invalid number.
std::optional<std::string> accelerator_name(ml_nnfw_hw_e hardware) {
  constexpr std::pair<ml_nnfw_hw_e, const char*> kNames[]{{ML_NNFW_HW_ANY, ""},
                                                          {ML_NNFW_HW_AUTO, "auto"},
                                                          {ML_NNFW_HW_DEFAULT, ""},
                                                          {ML_NNFW_HW_CPU, "cpu"},
                                                          {ML_NNFW_HW_CPU_SIMD, "cpu.simd"},
                                                          {ML_NNFW_HW_GPU, "gpu"},
                                                          {ML_NNFW_HW_NPU, "npu"},
                                                          {ML_NNFW_HW_NPU_MOVIDIUS, "npu.movidius"},
                                                          {ML_NNFW_HW_NPU_EDGE_TPU, "npu.edgetpu"},
                                                          {ML_NNFW_HW_NPU_VIVANTE, "npu.vivante"},
                                                          {ML_NNFW_HW_NPU_SLSI, "npu.slsi"},
                                                          {ML_NNFW_HW_NPU_SR, "npu.sr"}};
  for (const auto& [number, name] : kNames)
    if (number == hardware) return name;
  return std::nullopt;
}

Error no_such_number(const char* what, int number, const char* needed) {
  return Error{.code = Code::OPTION_VALUE,
               .what = what,
               .offered = std::to_string(number),
               .needed = needed};
}

Error nothing_came() {
  return Error{.code = Code::INVOKE_FAILED,
               .what = "the model returned no output for these inputs",
               .needed = "at least one output"};
}

// Replaces the functions of weir/model.h in the error's fix by those of this API.
Error in_calls_of_this_face(Error error) {
  if (error.fix.starts_with("model.reshape")) error.fix = "ml_single_set_input_info(single, info)";
  return error;
}

}  // namespace

Result<std::shared_ptr<Single>> Single::open(const SingleRequest& request) {
  const auto engine = framework_name(request.framework, request.model);
  if (!engine)
    return no_such_number("nnfw is not a value of ml_nnfw_type_e", request.framework,
                          "ML_NNFW_TYPE_ANY to ML_NNFW_TYPE_EXECUTORCH");
  const auto accelerator = accelerator_name(request.hardware);
  if (!accelerator)
    return no_such_number(
        "hw is not a value of ml_nnfw_hw_e", request.hardware,
        "a value from nnstreamer-single.h, such as ML_NNFW_HW_ANY or ML_NNFW_HW_CPU");
  std::vector<std::string> paths;
  for (const auto path : split(request.model, ",")) paths.emplace_back(strip(path));
  std::vector<const char*> c_paths;
  c_paths.reserve(paths.size());
  for (const auto& path : paths) c_paths.push_back(path.c_str());
  const Pairs options = infer::custom_options(request.custom);
  Pairs declared;
  declare("input", request.inputs, &declared);
  declare("output", request.outputs, &declared);
  const auto c_custom = c_options(options), c_declared = c_options(declared);
  weir_model_options open = WEIR_MODEL_OPTIONS_INIT;
  open.paths = c_paths.data();
  open.n_paths = static_cast<uint32_t>(c_paths.size());
  open.engine = engine->c_str();
  open.accelerator = accelerator->c_str();
  open.options = c_custom.data();
  open.n_options = static_cast<uint32_t>(c_custom.size());
  open.declared = c_declared.data();
  open.n_declared = static_cast<uint32_t>(c_declared.size());
  weir_loaded_model* model = nullptr;
  CError error;
  const int result = weir_model_open(&open, &model, error.place());
  if (result < 0) return error.take(result);
  std::shared_ptr<Single> single(new Single(model, request, *accelerator));
  if (!request.inputs.empty())
    if (auto status = single->set_inputs(request.inputs); !status) return status.error();
  if (auto status = single->agree(); !status) return status.error();
  return single;
}

// Checks that the requested outputs match the model's, as far as the model gives them.
Status Single::agree() const {
  if (request_.outputs.empty()) return ok();
  const auto infos =
      get_infos(model_.get(), weir_model_output_count(model_.get()), weir_model_output);
  for (const auto& info : infos)
    if (!known(info)) return ok();
  return check_same("output_info differs from the outputs of the model", request_.outputs,
                    to_specs(infos));
}

TensorSpecs Single::inputs() const {
  return to_specs(get_infos(model_.get(), weir_model_input_count(model_.get()), weir_model_input));
}

TensorSpecs Single::outputs() const {
  return to_specs(
      get_infos(model_.get(), weir_model_output_count(model_.get()), weir_model_output));
}

Status Single::set_inputs(const TensorSpecs& wanted) {
  const auto infos =
      get_infos(model_.get(), weir_model_input_count(model_.get()), weir_model_input);
  std::vector<weir_tensor_info> shapes;
  for (size_t i = 0; i < wanted.size(); ++i)
    shapes.push_back(i < infos.size() ? with_rank(wanted[i], infos[i]) : c_info(wanted[i]));
  CError error;
  return error.status(weir_model_reshape(model_.get(), shapes.data(),
                                         static_cast<uint32_t>(shapes.size()), error.place()));
}

void Single::set_timeout(unsigned ms) noexcept {
  constexpr int64_t kNanoseconds = 1'000'000;
  weir_model_set_timeout(model_.get(), ms * kNanoseconds);
}

std::vector<weir_tensor> Single::fitted(const TensorsData& input, const TensorSpecs& shapes) const {
  const auto infos =
      get_infos(model_.get(), weir_model_input_count(model_.get()), weir_model_input);
  auto tensors = input.c_tensors();
  for (size_t i = 0; i < tensors.size(); ++i) {
    const TensorSpec& spec = i < shapes.size() ? shapes[i] : input.tensors()[i];
    tensors[i].info = i < infos.size() ? with_rank(spec, infos[i]) : c_info(spec);
  }
  return tensors;
}

Result<std::shared_ptr<TensorsData>> Single::invoke(const TensorsData& input,
                                                    const TensorSpecs& shapes) {
  const auto tensors = fitted(input, shapes);
  weir_results* raw = nullptr;
  CError error;
  const int result = weir_model_invoke(model_.get(), tensors.data(),
                                       static_cast<uint32_t>(tensors.size()), &raw, error.place());
  if (result < 0) return in_calls_of_this_face(error.take(result));
  if (!raw) return nothing_came();
  const std::shared_ptr<weir_results> results(raw, weir_results_free);
  std::vector<weir_tensor> out(weir_results_count(raw));
  for (uint32_t i = 0; i < out.size(); ++i) weir_results_tensor(raw, i, &out[i]);
  return make_data(out, results, TensorsData::Access::ReadOnly);
}

Status Single::invoke_into(const TensorsData& input, const TensorsData& output) {
  if (!output.writable())
    return Error{.code = Code::OPTION_VALUE,
                 .what = "the outputs cannot be written into this data",
                 .offered = "read-only data",
                 .needed = "data created with ml_tensors_data_create()",
                 .fix = "ml_tensors_data_create(output_info, &output)"};
  const auto tensors = fitted(input, {});
  auto into = output.c_tensors();
  CError error;
  const int result =
      weir_model_invoke_into(model_.get(), tensors.data(), static_cast<uint32_t>(tensors.size()),
                             into.data(), static_cast<uint32_t>(into.size()), error.place());
  if (result < 0) return in_calls_of_this_face(error.take(result));
  return result == 0 ? ok() : Status(nothing_came());
}

Result<std::string> Single::property(const std::string& name) const {
  const std::pair<const char*, std::string> all[]{{"framework", weir_model_engine(model_.get())},
                                                  {"model", request_.model},
                                                  {"custom", request_.custom},
                                                  {"accelerator", accelerator_},
                                                  {"input", join_shapes(inputs())},
                                                  {"inputtype", join_types(inputs())},
                                                  {"inputname", join_names(inputs())},
                                                  {"output", join_shapes(outputs())},
                                                  {"outputtype", join_types(outputs())},
                                                  {"outputname", join_names(outputs())}};
  std::vector<std::string> names;
  for (const auto& [known_name, value] : all) {
    if (name == known_name) return value;
    names.emplace_back(known_name);
  }
  const std::string close = nearest(name, names);
  const std::string list = join(names, ", ");
  return Error{.code = Code::OPTION_VALUE,
               .what = "no property has this name",
               .offered = name,
               .needed = "one of: " + list,
               .difference = close.empty() ? "" : "did you mean " + close + "?"};
}

Status Single::set_property(const std::string& name, const std::string& value) {
  const auto now = property(name);
  if (!now) return now.error();
  if (name != "input")
    return Error{.code = Code::OPTION_VALUE,
                 .what = "this property is read-only after the model is opened",
                 .offered = name + "=" + value,
                 .needed = "the property input, the only one that can be set on an open model",
                 .fix = "open the model with this value: ml_single_open_full()"};
  const auto shapes = parse_shape_list(value);
  if (!shapes) return shapes.error();
  TensorSpecs wanted = inputs();
  if (wanted.size() != shapes->size())
    return Error{.code = Code::SPEC_MISMATCH,
                 .what = "the number of shapes differs from the number of inputs of the model",
                 .offered = value,
                 .needed = std::to_string(wanted.size()) + ": " + describe(wanted),
                 .difference = "number of tensors"};
  for (size_t i = 0; i < wanted.size(); ++i) wanted[i].shape = (*shapes)[i];
  return set_inputs(wanted);
}

}  // namespace weir::application
