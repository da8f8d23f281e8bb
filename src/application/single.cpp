// Single: uses weir/model.h; reverses dimensions, and ignores differences in trailing 1s.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "single.hpp"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <utility>
#include <vector>

#include "core/direct/direct_model.hpp"
#include "core/infer/module/custom_options.hpp"
#include "core/infer/module/known_engines.hpp"
#include "core/infer/module/module_library.hpp"
#include "core/text/text.hpp"
#include "nnfw.hpp"
#include "weir/c_error.hpp"
#include "weir/join.hpp"

namespace weir::application {
namespace {

constexpr int64_t kNanoseconds = 1'000'000;  // of a millisecond

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

namespace {

using Model = std::shared_ptr<weir_loaded_model>;

std::vector<weir_tensor_info> input_infos(const Model& model) {
  return get_infos(model.get(), weir_model_input_count(model.get()), weir_model_input);
}

std::vector<weir_tensor_info> output_infos(const Model& model) {
  return get_infos(model.get(), weir_model_output_count(model.get()), weir_model_output);
}

std::vector<std::string> split_paths(const std::string& model) {
  std::vector<std::string> out;
  for (const auto path : split(model, ",")) out.emplace_back(strip(path));
  return out;
}

Refusal unsupported(Error error) {
  return Refusal{ML_ERROR_NOT_SUPPORTED, std::move(error)};
}

Refusal invalid(Error error) {
  return Refusal{ML_ERROR_INVALID_PARAMETER, std::move(error)};
}

Status check_files(const SingleRequest& request, const std::vector<std::string>& paths) {
  for (const auto& path : paths) {
    std::error_code ignored;
    const bool is_folder = std::filesystem::is_directory(path, ignored);
    if (std::filesystem::is_regular_file(path, ignored) ||
        (is_folder && request.framework == "nnfw"))
      continue;
    return Error{.code = Code::MODEL_NOT_FOUND,
                 .what = is_folder ? "the model is a folder" : "the model file does not exist",
                 .offered = path,
                 .needed = "a file"};
  }
  return ok();
}

// Sets the engine for ML_NNFW_TYPE_ANY. A custom filter without a file is one of the program.
Status choose_framework(const std::vector<std::string>& paths, SingleRequest* request) {
  std::error_code ignored;
  if (request->type == ML_NNFW_TYPE_CUSTOM_FILTER && request->framework == "custom" &&
      paths.size() == 1 && !std::filesystem::exists(paths[0], ignored))
    request->framework = "custom-easy";
  if (!request->framework.empty()) return ok();
  const auto choice = infer::ModuleLibrary::instance().choose_engine(paths);
  if (!choice) return choice.error();
  request->framework = choice->engine;
  request->type = framework_number(choice->engine);
  return ok();
}

// What NNStreamer checks before it opens a model, in its order.
std::optional<Refusal> check_request(SingleRequest* request) {
  const auto paths = split_paths(request->model);
  const bool is_by_name = request->type == ML_NNFW_TYPE_ANY && !request->framework.empty();
  if (auto status = choose_framework(paths, request);
      !status && check_files(*request, paths))  // a missing file is the first reason
    return invalid(status.error());
  const bool has_files = request->framework != "custom-easy" && request->framework != "oip";
  if (has_files)
    if (auto status = check_files(*request, paths); !status) return invalid(status.error());
  if (has_files && !is_by_name)
    if (auto status = check_model_name(request->type, paths); !status)
      return invalid(status.error());
  const auto needs = [&](const char* what) {
    return Error{.code = Code::OPTION_VALUE,
                 .what = std::string("the framework ") + request->framework + what,
                 .offered = request->model};
  };
  if (is_unsupported(request->type)) return unsupported(needs(" is not supported"));
  if (auto status = check_available(request->framework, request->accelerator, nullptr); !status)
    return unsupported(status.error());
  if (needs_infos(request->type) && (request->inputs.empty() || request->outputs.empty()))
    return invalid(needs(" needs input_info and output_info"));
  return std::nullopt;
}

// A framework that refuses its model is a failure, not a wrong argument.
Refusal cannot_open(const Error& error) {
  switch (error.code) {
    case Code::ENGINE_UNKNOWN:
    case Code::ENGINE_NOT_INSTALLED:
    case Code::OUT_OF_MEMORY:
    case Code::CALLBACK_UNKNOWN:
    case Code::SPEC_MISMATCH:
      return refusal(error);
    default:
      return Refusal{ML_ERROR_STREAMS_PIPE, error};
  }
}

// A call during an invoke that has timed out may be tried again.
Refusal cannot_invoke(const Error& error) {
  if (error.code == Code::WORKER_TIMEOUT && error.what != direct::kInvokeTimedOut)
    return Refusal{ML_ERROR_TRY_AGAIN, error};
  return refusal(in_calls_of_this_face(error));
}

// The specs in the rank of the model. In a model of any rank, in their own rank without trailing 1s
// and `more` 1s.
std::vector<weir_tensor_info> in_rank(const TensorSpecs& wanted,
                                      const std::vector<weir_tensor_info>& model, size_t more) {
  std::vector<weir_tensor_info> out;
  for (size_t i = 0; i < wanted.size(); ++i) {
    const bool is_any = i < model.size() && model[i].rank > WEIR_RANK_LIMIT;
    TensorSpec spec = wanted[i];
    if (is_any)
      spec.shape = spec.shape.with_rank(std::min(kRankLimit, spec.shape.min_rank() + more));
    out.push_back(i < model.size() && !is_any ? with_rank(spec, model[i]) : c_info(spec));
    out.back().name = nullptr;
  }
  return out;
}

Status reshape(const Model& model, const TensorSpecs& wanted,
               const std::vector<weir_tensor_info>& declared) {
  const bool is_any_rank = std::any_of(declared.begin(), declared.end(), [](const auto& info) {
    return info.rank > WEIR_RANK_LIMIT;
  });
  Status status = ok();
  for (size_t more = 0; more < (is_any_rank ? kRankLimit : 1); ++more) {
    const auto shapes = in_rank(wanted, declared, more);
    CError error;
    status = error.status(weir_model_reshape(model.get(), shapes.data(),
                                             static_cast<uint32_t>(shapes.size()), error.place()));
    if (status) break;
  }
  return status;
}

// Gives tensors the descriptions of the model if their sizes agree, whatever their types. Shapes
// that the model leaves open are those of the tensors. FRAME_SIZE: a size differs.
Status take_descriptions(const std::vector<weir_tensor_info>& infos, const char* role,
                         std::vector<weir_tensor>* tensors) {
  for (size_t i = 0; i < tensors->size() && i < infos.size(); ++i) {
    weir_tensor& tensor = (*tensors)[i];
    const auto needed = to_spec(infos[i]);
    if (known(infos[i]) && needed.bytes() != tensor.bytes)
      return Error{.code = Code::FRAME_SIZE,
                   .what = std::string(role) + " " + std::to_string(i) +
                           " has a size that does not match the info of the model",
                   .offered = describe({to_spec(tensor.info)}),
                   .needed = describe({needed})};
    tensor.info = known(infos[i]) ? infos[i] : with_rank(to_spec(tensor.info), infos[i]);
    tensor.info.name = nullptr;
  }
  return ok();
}

}  // namespace

Single::Outcome<std::shared_ptr<Single>> Single::open(SingleRequest request) {
  if (auto refused = check_request(&request)) return *std::move(refused);
  auto model = load(request, false);
  if (!model) return cannot_open(model.error());
  std::shared_ptr<Single> single(new Single(*std::move(model), std::move(request)));
  const auto& inputs = single->request_.inputs;
  if (!inputs.empty()) {
    auto set = single->set_inputs(inputs);
    if (auto* refused = std::get_if<Refusal>(&set)) return invalid(std::move(refused->error));
  }
  if (auto status = single->agree(); !status) return invalid(status.error());
  return single;
}

Single::Single(Model model, SingleRequest request)
    : request_(std::move(request)), model_(std::move(model)), declared_(input_infos(model_)) {
  has_open_inputs_ = !std::all_of(declared_.begin(), declared_.end(), known);
}

// `resizable`: the shapes of the inputs are open, whatever the file says.
Result<Single::Model> Single::load(const SingleRequest& request, bool resizable) {
  const auto paths = split_paths(request.model);
  std::vector<const char*> c_paths;
  c_paths.reserve(paths.size());
  for (const auto& path : paths) c_paths.push_back(path.c_str());
  Pairs options = infer::custom_options(request.custom);
  if (resizable) options.emplace_back("Resize", "rank");
  Pairs declared;
  declare("input", request.inputs, &declared);
  declare("output", request.outputs, &declared);
  const auto c_custom = c_options(options), c_declared = c_options(declared);
  weir_model_options open = WEIR_MODEL_OPTIONS_INIT;
  open.paths = c_paths.data();
  open.n_paths = static_cast<uint32_t>(c_paths.size());
  open.engine = request.framework.c_str();
  open.accelerator = request.accelerator == "default" ? "" : request.accelerator.c_str();
  open.options = c_custom.data();
  open.n_options = static_cast<uint32_t>(c_custom.size());
  open.declared = c_declared.data();
  open.n_declared = static_cast<uint32_t>(c_declared.size());
  weir_loaded_model* model = nullptr;
  CError error;
  const int result = weir_model_open(&open, &model, error.place());
  if (result < 0) return error.take(result);
  return Model(model, weir_model_close);
}

Single::Model Single::model() const {
  std::lock_guard lock(mutex_);
  return model_;
}

// Checks that the requested outputs match the model's, as far as the model gives them.
Status Single::agree() const {
  if (request_.outputs.empty()) return ok();
  const auto infos = output_infos(model());
  if (!std::all_of(infos.begin(), infos.end(), known)) return ok();
  return check_same("output_info differs from the outputs of the model", request_.outputs,
                    to_specs(infos));
}

TensorSpecs Single::inputs() const {
  std::lock_guard lock(mutex_);
  return to_specs(pending_.empty() ? input_infos(model_) : pending_);
}

TensorSpecs Single::outputs() const {
  return to_specs(output_infos(model()));
}

// The model again, with inputs of any shape.
Single::Outcome<Single::Done> Single::replace_model(const TensorSpecs& wanted) {
  const auto other = load(request_, true);
  if (!other) return invalid(other.error());
  auto declared = input_infos(*other);
  if (auto status = reshape(*other, wanted, declared); !status) return invalid(status.error());
  std::lock_guard lock(mutex_);
  weir_model_set_timeout(other->get(), timeout_ms_ * kNanoseconds);
  model_ = *other;
  declared_ = std::move(declared);
  return Done();
}

Single::Outcome<Single::Done> Single::set_inputs(const TensorSpecs& wanted) {
  std::lock_guard lock(inputs_mutex_);
  return change_inputs(wanted);
}

Single::Outcome<Single::Done> Single::change_inputs(const TensorSpecs& wanted) {
  if (auto status = restore_pending(); !status) return cannot_invoke(status.error());
  const auto current = model();
  const auto now = to_specs(input_infos(current));
  if (!has_open_inputs_ && first_difference(wanted, now).empty()) return Done();
  const Status status = reshape(current, wanted, declared_);
  if (status) return Done();
  if (status.error().code == Code::WORKER_TIMEOUT) return cannot_invoke(status.error());
  const bool differs_in_shape =
      wanted.size() == now.size() &&
      std::equal(wanted.begin(), wanted.end(), now.begin(),
                 [](const auto& a, const auto& b) { return a.type == b.type; });
  if (!differs_in_shape || has_open_inputs_) return invalid(status.error());
  const auto* engine = infer::known_engine(request_.framework);
  if (!engine || engine->name != "tensorflow-lite") return unsupported(status.error());
  return replace_model(wanted);
}

void Single::set_timeout(unsigned ms) noexcept {
  std::lock_guard lock(mutex_);
  timeout_ms_ = ms;
  weir_model_set_timeout(model_.get(), ms * kNanoseconds);
}

Single::Outcome<std::shared_ptr<TensorsData>> Single::invoke(const TensorsData& input) {
  {
    std::lock_guard lock(inputs_mutex_);
    if (auto status = restore_pending(); !status) return cannot_invoke(status.error());
  }
  return run(input);
}

Single::Outcome<std::shared_ptr<TensorsData>> Single::run(const TensorsData& input) {
  const auto current = model();
  auto tensors = input.c_tensors();
  if (auto status = take_descriptions(input_infos(current), "input", &tensors); !status)
    return invalid(status.error());
  weir_results* raw = nullptr;
  CError error;
  const int result = weir_model_invoke(current.get(), tensors.data(),
                                       static_cast<uint32_t>(tensors.size()), &raw, error.place());
  if (result < 0) return cannot_invoke(error.take(result));
  if (!raw) return refusal(nothing_came());
  const std::shared_ptr<weir_results> results(raw, weir_results_free);
  std::vector<weir_tensor> out(weir_results_count(raw));
  for (uint32_t i = 0; i < out.size(); ++i) weir_results_tensor(raw, i, &out[i]);
  const bool is_lent = std::any_of(out.begin(), out.end(), [](const weir_tensor& tensor) {
    return (tensor.flags & WEIR_TENSOR_READONLY) != 0;
  });
  return make_data(out, results,
                   is_lent ? TensorsData::Access::ReadOnly : TensorsData::Access::ReadWrite);
}

Single::Outcome<Single::Done> Single::invoke_into(const TensorsData& input,
                                                  const TensorsData& output) {
  if (!output.writable())
    return invalid(Error{.code = Code::OPTION_VALUE,
                         .what = "the outputs cannot be written into this data",
                         .offered = "read-only data",
                         .needed = "data created with ml_tensors_data_create()",
                         .fix = "ml_tensors_data_create(output_info, &output)"});
  {
    std::lock_guard lock(inputs_mutex_);
    if (auto status = restore_pending(); !status) return cannot_invoke(status.error());
  }
  const auto current = model();
  auto tensors = input.c_tensors();
  if (auto status = take_descriptions(input_infos(current), "input", &tensors); !status)
    return invalid(status.error());
  auto into = output.c_tensors();
  if (auto status = take_descriptions(output_infos(current), "output", &into); !status)
    return invalid(status.error());
  CError error;
  const int result =
      weir_model_invoke_into(current.get(), tensors.data(), static_cast<uint32_t>(tensors.size()),
                             into.data(), static_cast<uint32_t>(into.size()), error.place());
  if (result < 0) return cannot_invoke(error.take(result));
  if (result > 0) return refusal(nothing_came());
  return Done();
}

Single::Outcome<std::shared_ptr<TensorsData>> Single::invoke_dynamic(const TensorsData& input,
                                                                     const TensorSpecs& inputs) {
  std::lock_guard lock(inputs_mutex_);
  if (auto status = restore_pending(); !status) return cannot_invoke(status.error());
  const auto before = model();
  const auto declared_before = declared_;
  auto infos_before = input_infos(before);
  auto set = change_inputs(inputs);
  if (auto* refused = std::get_if<Refusal>(&set)) return std::move(*refused);
  auto out = run(input);
  if (std::holds_alternative<Refusal>(out))
    restore(before, declared_before, std::move(infos_before));
  return out;
}

// Where the shapes were open, they are open again.
void Single::restore(const Model& model, const Infos& declared, Infos infos) {
  {
    std::lock_guard lock(mutex_);
    weir_model_set_timeout(model.get(), timeout_ms_ * kNanoseconds);
    model_ = model;
    declared_ = declared;
    pending_ = std::move(infos);
  }
  (void)restore_pending();
}

Status Single::restore_pending() {
  if (pending_.empty()) return ok();
  auto infos = pending_;
  for (auto& info : infos)
    if (!known(info)) info.rank = WEIR_RANK_UNKNOWN;
  CError error;
  const int result = weir_model_reshape(model_.get(), infos.data(),
                                        static_cast<uint32_t>(infos.size()), error.place());
  if (result == -WEIR_WORKER_TIMEOUT) return error.take(result);
  std::lock_guard lock(mutex_);
  pending_.clear();
  return ok();
}

}  // namespace weir::application
