// SPDX-License-Identifier: LGPL-2.1-or-later
#include "onnxruntime/ort_runner.hpp"

#include <algorithm>
#include <cstring>

#include "dry_run.hpp"
#include "onnxruntime/symbolic_shapes.hpp"
#include "tensor_check.hpp"
#include "weir/engine_tools.hpp"

namespace weir::engine {
namespace {

Error invoke_error(const OrtFailure& failure) {
  if (is_out_of_memory(failure))
    return Error{.code = Code::OUT_OF_MEMORY,
                 .what = "ONNX Runtime has no memory for a frame",
                 .offered = failure.text,
                 .needed = {},
                 .difference = {},
                 .fix = {}};
  const bool shapes = failure.code == ORT_INVALID_ARGUMENT;
  return Error{.code = shapes ? Code::SPEC_MISMATCH : Code::INVOKE_FAILED,
               .what = shapes ? "ONNX Runtime rejects the shape or type of a tensor"
                              : "ONNX Runtime failed on a frame",
               .offered = failure.text};
}

bool is_within(const void* data, const weir_tensor& tensor) {
  const auto* at = static_cast<const std::byte*>(data);
  const auto* begin = static_cast<const std::byte*>(tensor.data);
  return begin && at >= begin && at < begin + tensor.bytes;
}

// Frees memory that was handed over with an output: its consumer calls it at any later time.
void release_value(void* owner) {
  std::unique_ptr<OrtOwner<OrtValue>> ended(static_cast<OrtOwner<OrtValue>*>(owner));
}

}  // namespace

OrtRunner::OrtRunner(const OrtModel& model) : model_(model), api_(model.runtime().api()) {
  const size_t n_in = model.inputs().infos.size(), n_out = model.outputs().infos.size();
  for (size_t i = 0; i < n_in; ++i) inputs_.emplace_back(nullptr, api_.ReleaseValue);
  for (size_t i = 0; i < n_out; ++i) outputs_.emplace_back(nullptr, api_.ReleaseValue);
  input_pointers_.resize(n_in);
  output_pointers_.resize(n_out);
  bools_.resize(n_in);
}

Result<std::unique_ptr<OrtRunner>> OrtRunner::create(const OrtModel& model,
                                                     std::span<const weir_option>) {
  return std::unique_ptr<OrtRunner>(new OrtRunner(model));
}

Result<OrtRunner::Value> OrtRunner::wrap(void* data, const weir_tensor_info& info, uint64_t bytes,
                                         ONNXTensorElementDataType type) const {
  OrtValue* value = nullptr;
  if (auto bad = take(
          api_, api_.CreateTensorWithDataAsOrtValue(model_.runtime().host_memory(), data, bytes,
                                                    info.shape, info.rank, type, &value)))
    return invoke_error(bad);
  return Value(value, api_.ReleaseValue);
}

Status OrtRunner::bind_inputs(const weir_frame& in) {
  const auto& ports = model_.inputs();
  const auto given = get_tensors(in);
  if (auto status = check_inputs(ports.infos, given); !status) return status;
  for (size_t i = 0; i < given.size(); ++i) {
    const weir_tensor& tensor = given[i];
    void* data = tensor.data;
    if (ports.types[i] == ONNX_TENSOR_ELEMENT_DATA_TYPE_BOOL) {
      const auto* bytes = static_cast<const uint8_t*>(data);
      bools_[i].resize(tensor.bytes);
      std::transform(bytes, bytes + tensor.bytes, bools_[i].begin(),
                     [](uint8_t byte) { return static_cast<uint8_t>(byte != 0); });
      data = bools_[i].data();
    }
    auto value = wrap(data, tensor.info, tensor.bytes, ports.types[i]);
    if (!value) return value.error();
    inputs_[i] = *std::move(value);
    input_pointers_[i] = inputs_[i].get();
  }
  return ok();
}

Status OrtRunner::bind_outputs(const weir_frame& out) {
  const auto& ports = model_.outputs();
  const auto given = get_tensors(out);
  if (auto status = check_outputs(ports.infos, given); !status) return status;
  for (size_t i = 0; i < given.size(); ++i) {
    const weir_tensor& tensor = given[i];
    output_pointers_[i] = nullptr;
    if (!tensor.data) continue;  // ONNX Runtime allocates
    if (auto status = check_infos({&ports.infos[i], 1}, {&tensor.info, 1}, "output"); !status)
      return status;
    auto value = wrap(tensor.data, tensor.info, tensor.bytes, ports.types[i]);
    if (!value) return value.error();
    outputs_[i] = *std::move(value);
    output_pointers_[i] = outputs_[i].get();
  }
  return ok();
}

Status OrtRunner::run() {
  OrtStatus* status = api_.Run(model_.session(), nullptr, model_.inputs().name_pointers.data(),
                               input_pointers_.data(), input_pointers_.size(),
                               model_.outputs().name_pointers.data(), output_pointers_.size(),
                               output_pointers_.data());
  const auto bad = take(api_, status);
  // Also after a failure, we own what Run allocated.
  for (size_t i = 0; i < outputs_.size(); ++i)
    if (outputs_[i].get() != output_pointers_[i]) outputs_[i].reset(output_pointers_[i]);
  return bad ? Status(invoke_error(bad)) : ok();
}

Status OrtRunner::get_shape(const OrtValue* value, weir_tensor_info* info) const {
  OrtTensorTypeAndShapeInfo* raw = nullptr;
  if (auto bad = take(api_, api_.GetTensorTypeAndShape(value, &raw))) return invoke_error(bad);
  const OrtOwner<OrtTensorTypeAndShapeInfo> type(raw, api_.ReleaseTensorTypeAndShapeInfo);
  size_t rank = 0;
  take(api_, api_.GetDimensionsCount(type.get(), &rank));
  if (rank > WEIR_RANK_LIMIT) return unsupported_rank("an output", static_cast<long long>(rank));
  info->rank = static_cast<uint32_t>(rank);
  std::fill(std::begin(info->shape), std::end(info->shape), 0);
  if (rank > 0) take(api_, api_.GetDimensions(type.get(), info->shape, rank));
  return ok();
}

Status OrtRunner::hand_over(const weir_frame& in, size_t index, weir_tensor* tensor) {
  void* data = nullptr;
  if (auto bad = take(api_, api_.GetTensorMutableData(outputs_[index].get(), &data)))
    return invoke_error(bad);
  if (tensor->data) {
    // Written in place, unless the model passes an input or a constant through.
    if (data != tensor->data) std::memcpy(tensor->data, data, tensor->bytes);
    return ok();
  }
  tensor->info = model_.outputs().infos[index];
  if (auto status = get_shape(outputs_[index].get(), &tensor->info); !status) return status;
  tensor->bytes = tensor->capacity = tensor_bytes(tensor->info).value_or(0);
  const auto given = get_tensors(in);
  if (std::any_of(given.begin(), given.end(),
                  [data](const weir_tensor& input) { return is_within(data, input); })) {
    return write_output(weir_tensor_info(tensor->info), data, index, tensor);
  }
  auto lent = std::make_unique<Value>(std::move(outputs_[index]));
  outputs_[index] = Value(nullptr, api_.ReleaseValue);
  tensor->data = data;
  tensor->release = release_value;
  tensor->owner = lent.release();
  return ok();
}

Status OrtRunner::hand_over(const weir_frame& in, weir_frame& out) {
  for (size_t i = 0; i < outputs_.size(); ++i)
    if (auto status = hand_over(in, i, &out.tensors[i]); !status) return status;
  return ok();
}

void OrtRunner::unbind() noexcept {
  for (auto& value : inputs_) value.reset();
  for (auto& value : outputs_) value.reset();
}

Status OrtRunner::invoke(const weir_frame& in, weir_frame& out) {
  struct Unbind {
    OrtRunner* self;
    ~Unbind() { self->unbind(); }
  } const unbind{this};
  if (auto status = bind_inputs(in); !status) return status;
  if (auto status = bind_outputs(out); !status) return status;
  if (auto status = run(); !status) return status;
  return hand_over(in, out);
}

Status OrtRunner::dry_run(std::span<const weir_tensor_info> in, std::span<weir_tensor_info> out) {
  auto inputs = DryRunInputs::create(in);
  if (!inputs) return inputs.error();
  std::vector<weir_tensor> outputs(out.size());
  weir_frame in_frame{}, out_frame{};
  in_frame.n_tensors = static_cast<uint32_t>(in.size());
  in_frame.tensors = inputs->tensors().data();
  out_frame.n_tensors = static_cast<uint32_t>(outputs.size());
  out_frame.tensors = outputs.data();
  Status status = invoke(in_frame, out_frame);
  for (size_t i = 0; i < outputs.size(); ++i) {
    if (status) {
      out[i].rank = outputs[i].info.rank;
      std::copy(std::begin(outputs[i].info.shape), std::end(outputs[i].info.shape), out[i].shape);
    }
    if (outputs[i].release) outputs[i].release(outputs[i].owner);
  }
  return status;
}

Status OrtRunner::resolve(std::span<const weir_tensor_info> in, std::span<weir_tensor_info> out) {
  const auto &inputs = model_.inputs(), &outputs = model_.outputs();
  if (auto status = check_infos(inputs.infos, in, "input"); !status) return status;
  if (auto status = check_count(outputs.infos, out.size(), "output"); !status) return status;
  std::copy(outputs.infos.begin(), outputs.infos.end(), out.begin());
  last_inputs_.assign(in.begin(), in.end());
  substitute_symbols(in, inputs.symbols, out, outputs.symbols);
  const auto fixed = [](std::span<const weir_tensor_info> infos) {
    return std::all_of(infos.begin(), infos.end(), is_fixed);
  };
  if (fixed(out) || !fixed(in) || model_.shapes_depend_on_data()) return ok();
  std::vector<weir_tensor_info> found(out.begin(), out.end());
  if (auto status = dry_run(in, found); !status) {
    if (status.error().code == Code::OUT_OF_MEMORY) return status;
    // Too large, or the model fails on zeros: the first frame determines the shapes.
    log(WEIR_LOG_INFO, "a dry run finds no output shapes: " + status.error().message());
    return ok();
  }
  std::copy(found.begin(), found.end(), out.begin());
  return ok();
}

Status OrtRunner::warm() {
  const auto& inputs = last_inputs_.empty() ? model_.inputs().infos : last_inputs_;
  if (!std::all_of(inputs.begin(), inputs.end(), is_fixed)) return ok();
  std::vector<weir_tensor_info> out(model_.outputs().infos);
  const Status status = dry_run(inputs, out);
  return !status && status.error().code == Code::LIMIT_EXCEEDED ? ok() : status;
}

}  // namespace weir::engine
