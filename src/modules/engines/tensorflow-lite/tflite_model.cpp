// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tensorflow-lite/tflite_model.hpp"

#include <tensorflow/lite/c/c_api_types.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "model_bytes.hpp"
#include "tflite-file/tflite_metadata.hpp"
#include "tflite-file/tflite_work.hpp"
#include "usable_cores.hpp"
#include "weir/abi.h"
#include "weir/engine_tools.hpp"

namespace weir::engine {
namespace {

// Bool is last: Weir has no bool and uses a byte of 0 or 1.
constexpr std::array<std::pair<TfLiteType, weir_type>, 11> kTfliteTypes{
    {{kTfLiteFloat32, WEIR_FLOAT32},
     {kTfLiteInt32, WEIR_INT32},
     {kTfLiteUInt8, WEIR_UINT8},
     {kTfLiteInt64, WEIR_INT64},
     {kTfLiteInt16, WEIR_INT16},
     {kTfLiteInt8, WEIR_INT8},
     {kTfLiteFloat16, WEIR_FLOAT16},
     {kTfLiteFloat64, WEIR_FLOAT64},
     {kTfLiteUInt64, WEIR_UINT64},
     {kTfLiteUInt32, WEIR_UINT32},
     {kTfLiteBool, WEIR_UINT8}}};

std::optional<weir_type> from_tflite(TfLiteType type) noexcept {
  for (const auto& [theirs, ours] : kTfliteTypes)
    if (theirs == type) return ours;
  return std::nullopt;
}

// For messages.
const char* tflite_type_name(TfLiteType type) noexcept {
  static constexpr std::array kNames{"none",    "float32", "int32",      "uint8",     "int64",
                                     "string",  "bool",    "int16",      "complex64", "int8",
                                     "float16", "float64", "complex128", "uint64",    "resource",
                                     "variant", "uint32"};
  return static_cast<size_t>(type) < kNames.size() ? kNames[type] : "unknown";
}

// Readable bytes after the file: tables are validated up to their end, at which an option of up to
// 8 bytes may be read.
constexpr size_t kReadablePadding = 64;

// Marks the dimensions that the model leaves to the stream.
void open_dimensions(const TfLiteTensor& tensor, weir_tensor_info* info) {
  const TfLiteIntArray* signature = tensor.dims_signature;
  if (!signature || static_cast<uint32_t>(signature->size) != info->rank) return;
  for (uint32_t i = 0; i < info->rank; ++i)
    if (signature->data[i] < 0) info->shape[i] = -1;
}

// TensorFlow puts channels last; models converted from elsewhere have them before the rows.
uint32_t find_layout(const weir_tensor_info& info) {
  const auto colours = [](int64_t extent) { return extent == 1 || extent == 3 || extent == 4; };
  if (info.rank != 4) return WEIR_LAYOUT_ANY;
  if (colours(info.shape[3])) return WEIR_LAYOUT_NHWC;
  return colours(info.shape[1]) ? WEIR_LAYOUT_NCHW : WEIR_LAYOUT_ANY;
}

// XNNPACK's threads spin for about 9 ms after each invoke, and an invoke waits for all of them at
// each operator even if others use their cores. Next to two busy threads on two cores, MobileNet v1
// 0.25 (41 million multiplications) takes ten times as long with two threads as with one, and
// DeepLab v3 (726 million) 2.2 times. On an idle machine two threads save a third to two fifths. So
// only models whose frames take milliseconds get several threads.
constexpr ThreadCosts kThreadCosts{.of_operator = 1, .of_invoke = 50e6, .of_weight = 0};

// Chooses what the options leave open.
void complete(std::span<const std::byte> file, TfliteOptions* options) {
  if (options->xnnpack && options->threads > 0) return;
  const auto graph = read_tflite_graph(file);
  if (!options->xnnpack) options->xnnpack = !graph || suits_xnnpack(*graph);
  if (options->threads > 0) return;
  // TensorFlow Lite's own kernels do not benefit from threads.
  options->threads = graph && *options->xnnpack
                         ? threads_for(tflite_work(*graph), kThreadCosts, usable_cores())
                         : 1;
}

}  // namespace

bool is_unallocated(const TfLiteTensor& tensor) noexcept {
  return tensor.allocation_type == kTfLiteDynamic || (!tensor.data.raw && tensor.bytes > 0);
}

Result<weir_tensor_info> tflite_tensor_info(const TfliteApi& api, const TfLiteTensor& tensor) {
  weir_tensor_info info = open_tensor_info();
  const std::string name = tensor.name ? tensor.name : "";
  const auto type = from_tflite(tensor.type);
  if (!type)
    return unsupported_type("the model's tensor " + name,
                            std::string("elements of type ") + tflite_type_name(tensor.type),
                            "export the model without it");
  const int rank = tensor.dims ? tensor.dims->size : 0;
  if (rank < 0 || rank > WEIR_RANK_LIMIT)
    return unsupported_rank("the model's tensor " + name, rank);
  info.type = *type;
  set_shape(&info, tensor.dims ? tensor.dims->data : nullptr, static_cast<size_t>(rank));
  const auto quantization = api.quantization(&tensor);
  info.scale = quantization.scale;
  info.zero_point = quantization.zero_point;
  return info;
}

TfliteModel::TfliteModel(const TfliteApi& api) : api_(api), model_(nullptr, api.model_delete) {}

Result<std::unique_ptr<TfliteModel>> TfliteModel::open(const weir_open& request) {
  const auto api = TfliteApi::instance();
  if (!api) return api.error();
  const auto options = TfliteOptions::read(request);
  if (!options) return options.error();
  auto file = read_model(request, {.check_head = check_tflite_head});
  if (!file) return file.error();
  const size_t size = file->bytes.size();
  std::unique_ptr<TfliteModel> model(new TfliteModel(**api));
  model->bytes_ = std::move(file->owned);
  if (model->bytes_.empty()) model->bytes_.assign(file->bytes.begin(), file->bytes.end());
  model->bytes_.resize(size + kReadablePadding);
  const auto named = [&file](Error error) {
    error.offered = file->name() + ": " + error.offered;
    return error;
  };
  auto summary = read_tflite({model->bytes_.data(), size});
  if (!summary) return named(summary.error());
  model->summary_ = *std::move(summary);
  model->options_ = *options;
  complete({model->bytes_.data(), size}, &model->options_);
  // The delegate of 2.9 writes through a null pointer when no operator computes an output.
  if (model->summary_.passes_through) model->options_.xnnpack = false;
  model->model_.reset((*api)->model_create(model->bytes_.data(), size));
  if (!model->model_)
    return named({.code = Code::MODEL_INVALID, .what = "TensorFlow Lite cannot load the model"});
  auto interpreter = model->interpreter({});
  if (!interpreter) return named(interpreter.error());
  if (auto status = model->read_tensors(**interpreter); !status) return named(status.error());
  const bool delegated = model->packs_weights_ = (*interpreter)->delegated();
  model->first_ = *std::move(interpreter);
  const auto properties = tflite_properties({model->bytes_.data(), size}, model->summary_.metadata);
  const nlohmann::json metadata{{"custom_metadata_map", properties},
                                {"description", model->summary_.description},
                                {"operators", model->summary_.operators},
                                {"xnnpack", delegated}};
  model->metadata_ = metadata.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  return model;
}

Result<std::unique_ptr<TfliteInterpreter>> TfliteModel::interpreter(
    std::span<const weir_tensor_info> shapes) const {
  return TfliteInterpreter::create(api_, model_.get(), options_, shapes);
}

Result<std::unique_ptr<TfliteInterpreter>> TfliteModel::session_interpreter() const {
  {
    const std::lock_guard lock(first_mutex_);
    if (first_) return std::move(first_);
  }
  return interpreter({});
}

Result<weir_tensor_info> TfliteModel::read_tensor(const TfLiteTensor& tensor, bool is_input) {
  auto info = tflite_tensor_info(api_, tensor);
  if (!info) return info;
  open_dimensions(tensor, &*info);
  if (options_.resize || (!is_input && is_unallocated(tensor)))
    std::fill_n(info->shape, info->rank, -1);
  if (is_input) info->layout = find_layout(*info);
  if (options_.resize_rank) info->rank = WEIR_RANK_UNKNOWN;
  names_.emplace_back(tensor.name ? tensor.name : "");
  info->name = names_.back().c_str();
  return info;
}

Status TfliteModel::read_tensors(const TfliteInterpreter& interpreter) {
  const size_t n_in = interpreter.inputs(), n_out = interpreter.outputs();
  names_.reserve(n_in + n_out);
  bool batched = !options_.resize_rank;
  for (size_t i = 0; i < n_in + n_out; ++i) {
    const TfLiteTensor* tensor = i < n_in ? interpreter.input(i) : interpreter.output(i - n_in);
    const auto info = read_tensor(*tensor, i < n_in);
    if (!info) return info.error();
    batched = batched && info->rank > 0 && info->shape[0] == -1;
    (i < n_in ? inputs_ : outputs_).push_back(*info);
  }
  if (!batched) return ok();
  for (auto* list : {&inputs_, &outputs_})
    for (auto& info : *list) info.batch_axis = 0;
  return ok();
}

void TfliteModel::describe(weir_model_info* info) const {
  info->flags = summary_.has_state ? WEIR_MODEL_STATEFUL : 0;
  if (options_.threads > 1) info->flags |= WEIR_MODEL_FORK_UNSAFE;
  if (summary_.shapes_depend_on_data) info->flags |= WEIR_MODEL_DYNAMIC_OUTPUT;
  info->n_inputs = static_cast<uint32_t>(inputs_.size());
  info->n_outputs = static_cast<uint32_t>(outputs_.size());
  info->inputs = inputs_.data();
  info->outputs = outputs_.data();
  info->alignment = info->input_padding = 0;  // inputs are copied
  info->memory_kinds = uint64_t{1} << WEIR_MEMORY_HOST;
  // XNNPACK packs the weights again for each interpreter, so users of a model share one session.
  // Without packed weights there is no limit, nor for a model with state, which belongs to the
  // interpreter.
  info->max_sessions = packs_weights_ && !summary_.has_state ? 1 : 0;
  info->max_in_flight = 1;
  info->preferred_batch = 1;
  info->weight_bytes = bytes_.size() - kReadablePadding;
  info->metadata_json = metadata_.c_str();
}

}  // namespace weir::engine
