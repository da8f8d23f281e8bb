// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tensorflow-lite/tflite_runner.hpp"

#include <algorithm>
#include <cstring>

#include "dry_run.hpp"
#include "tensor_check.hpp"
#include "weir/engine_tools.hpp"

namespace weir::engine {
TfliteRunner::TfliteRunner(const TfliteModel& model, const TfliteApi& api,
                           std::unique_ptr<TfliteInterpreter> interpreter)
    : model_(model), api_(api), interpreter_(std::move(interpreter)) {}

Result<std::unique_ptr<TfliteRunner>> TfliteRunner::create(const TfliteModel& model,
                                                           std::span<const weir_option>) {
  const auto api = TfliteApi::instance();
  if (!api) return api.error();
  auto interpreter = model.session_interpreter();
  if (!interpreter) return interpreter.error();
  return std::unique_ptr<TfliteRunner>(new TfliteRunner(model, **api, *std::move(interpreter)));
}

// Accepts any extents of the right rank, if the model has one: models with a fixed shape can often
// be resized too.
Status TfliteRunner::check(std::span<const weir_tensor_info> in) const {
  auto any = model_.inputs();
  for (auto& info : any)
    if (info.rank <= WEIR_RANK_LIMIT) std::fill_n(info.shape, info.rank, -1);
  return check_infos(any, in, "input");
}

bool TfliteRunner::shaped_as(size_t index, const weir_tensor_info& info) const {
  const TfLiteIntArray* extents = interpreter_->input(index)->dims;
  return extents && static_cast<uint32_t>(extents->size) == info.rank &&
         std::equal(info.shape, info.shape + info.rank, extents->data);
}

Status TfliteRunner::reshape(std::span<const weir_tensor_info> in) {
  bool same = true;
  for (size_t i = 0; i < in.size(); ++i) {
    same = same && shaped_as(i, in[i]);
    const auto bytes = tensor_bytes(in[i]);
    if (!bytes || *bytes > INT32_MAX || *bytes == 0)
      return Error{.code = Code::SPEC_MISMATCH,
                   .what = "TensorFlow Lite does not accept an input of this size",
                   .offered = describe(in[i]),
                   .needed = "1 byte to 2 GiB"};
  }
  if (same) return ok();
  auto interpreter = model_.interpreter(in);
  if (!interpreter) {
    Error error = interpreter.error();
    if (error.needed.empty()) error.needed = describe(model_.inputs());
    return error;
  }
  interpreter_ = *std::move(interpreter);
  dry_ran_ = false;
  return ok();
}

Status TfliteRunner::dry_run() {
  std::vector<weir_tensor_info> infos;
  for (size_t i = 0; i < model_.inputs().size(); ++i) {
    const auto info = tflite_tensor_info(api_, *interpreter_->input(i));
    if (!info) return info.error();
    infos.push_back(*info);
  }
  if (auto status = check_dry_run(infos); !status) return status;
  for (size_t i = 0; i < model_.inputs().size(); ++i) {
    const TfLiteTensor* tensor = interpreter_->input(i);
    if (tensor->data.raw) std::memset(tensor->data.raw, 0, tensor->bytes);
  }
  Status status = interpreter_->invoke();
  if (model_.summary().has_state) interpreter_->reset_state();
  return status;
}

bool TfliteRunner::has_open_output() const {
  for (size_t i = 0; i < model_.outputs().size(); ++i)
    if (is_unallocated(*interpreter_->output(i))) return true;
  return false;
}

void TfliteRunner::find_output_shapes() {
  if (dry_ran_ || model_.summary().shapes_depend_on_data || !has_open_output()) return;
  const auto status = dry_run();
  dry_ran_ = bool(status);
  // Too large, or the model fails on zeros: the first frame determines the shapes.
  if (!status) log(WEIR_LOG_INFO, "a dry run finds no output shapes: " + status.error().message());
}

Status TfliteRunner::resolve(std::span<const weir_tensor_info> in,
                             std::span<weir_tensor_info> out) {
  if (auto status = check(in); !status) return status;
  if (auto status = check_count(model_.outputs(), out.size(), "output"); !status) return status;
  std::copy(model_.outputs().begin(), model_.outputs().end(), out.begin());
  if (!std::all_of(in.begin(), in.end(), is_fixed)) return ok();
  if (auto status = reshape(in); !status) return status;
  find_output_shapes();
  for (size_t i = 0; i < out.size(); ++i) {
    const auto now = tflite_tensor_info(api_, *interpreter_->output(i));
    if (!now) return now.error();
    out[i].rank = now->rank;
    const bool known = dry_ran_ || !is_unallocated(*interpreter_->output(i));
    for (uint32_t d = 0; d < now->rank; ++d) out[i].shape[d] = known ? now->shape[d] : -1;
  }
  return ok();
}

Status TfliteRunner::copy_in(const weir_tensor& tensor, size_t index) {
  if (auto status = check_memory(tensor, index, "input"); !status) return status;
  TfLiteTensor* to = interpreter_->input(index);
  const void* from = tensor.data;
  if (to->type == kTfLiteBool) {
    const auto* bytes = static_cast<const uint8_t*>(from);
    bools_.resize(tensor.bytes);
    std::transform(bytes, bytes + tensor.bytes, bools_.begin(),
                   [](uint8_t byte) { return static_cast<uint8_t>(byte != 0); });
    from = bools_.data();
  }
  if (!to->data.raw || api_.copy_from(to, from, tensor.bytes) != kTfLiteOk)
    return Error{.code = Code::INVOKE_FAILED,
                 .what = "TensorFlow Lite does not accept the data of an input",
                 .offered = std::to_string(tensor.bytes) + " bytes",
                 .needed = std::to_string(to->bytes) + " bytes"};
  return ok();
}

Status TfliteRunner::copy_out(size_t index, weir_tensor* tensor) {
  const TfLiteTensor* from = interpreter_->output(index);
  auto info = tflite_tensor_info(api_, *from);
  if (!info) return info.error();
  if ((!from->data.raw && from->bytes > 0) || tensor_bytes(*info) != from->bytes)
    return Error{.code = Code::INVOKE_FAILED,
                 .what = "TensorFlow Lite returned no data for an output",
                 .offered = "output " + std::to_string(index)};
  info->name = model_.outputs()[index].name;
  return write_output(*info, from->data.raw, index, tensor);
}

// Reshapes the model if the inputs of a frame have other shapes.
Status TfliteRunner::fit(std::span<const weir_tensor> inputs) {
  bool same = true;
  for (size_t i = 0; i < inputs.size(); ++i)
    same = same && inputs[i].info.type == model_.inputs()[i].type && shaped_as(i, inputs[i].info);
  if (same) return ok();
  std::vector<weir_tensor_info> infos;
  infos.reserve(inputs.size());
  for (const auto& tensor : inputs) infos.push_back(tensor.info);
  if (auto status = check(infos); !status) return status;
  return reshape(infos);
}

Status TfliteRunner::invoke(const weir_frame& in, weir_frame& out) {
  const auto inputs = get_tensors(in), outputs = get_tensors(out);
  if (auto status = check_count(model_.inputs(), inputs.size(), "input"); !status) return status;
  if (auto status = check_outputs(model_.outputs(), outputs); !status) return status;
  if (auto status = fit(inputs); !status) return status;
  for (size_t i = 0; i < inputs.size(); ++i)
    if (auto status = copy_in(inputs[i], i); !status) return status;
  if (auto status = interpreter_->invoke(); !status) return status;
  for (size_t i = 0; i < outputs.size(); ++i)
    if (auto status = copy_out(i, &out.tensors[i]); !status) return status;
  return ok();
}

Status TfliteRunner::warm() {
  static_cast<void>(dry_run());  // a model that fails on zeros is warm enough
  return ok();
}

Status TfliteRunner::reset_state() {
  interpreter_->reset_state();
  return ok();
}

}  // namespace weir::engine
