// Opens and invokes a model of any engine directly, without a pipeline. Wraps model.h: link with
// libweir (pkg-config weir).
//
//   auto model = weir::Model::open("mobilenet.onnx");
//   if (!model) return complain(model.error().message());
//   auto outputs = model->invoke({std::span<const uint8_t>(pixels)});
//   auto scores = outputs ? (*outputs)[0].as<float>() : outputs.error();
//
// Any thread may call; calls of one model are serialised. A moved-from object may only be assigned
// to or destroyed.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <chrono>
#include <initializer_list>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "weir/c_error.hpp"
#include "weir/model.h"
#include "weir/tensor_info.hpp"

namespace weir {

// The outputs of an invoke. Owns the memory; may outlive its model.
class Outputs {
 public:
  // Wraps `results`; null when the model has no output for these inputs: dropped().
  explicit Outputs(weir_results* results = nullptr) : results_(results) {}
  bool dropped() const noexcept { return !results_; }
  size_t size() const noexcept { return results_ ? weir_results_count(results_.get()) : 0; }
  size_t frames() const noexcept { return results_ ? weir_results_frames(results_.get()) : 0; }
  // Returns output `index` of all frames, borrowed from this object. Precondition: `index` <
  // size().
  Tensor operator[](size_t index) const noexcept {
    weir_tensor tensor{};
    if (results_) weir_results_tensor(results_.get(), static_cast<uint32_t>(index), &tensor);
    return Tensor(tensor);
  }
  // Returns the part of one frame of a batch, borrowed. Precondition: `frame` < frames().
  Tensor of_frame(size_t frame, size_t index) const noexcept {
    weir_tensor tensor{};
    if (results_)
      weir_results_frame_tensor(results_.get(), static_cast<uint32_t>(frame),
                                static_cast<uint32_t>(index), &tensor);
    return Tensor(tensor);
  }
  // Returns the output with this name; nullopt if there is none.
  std::optional<Tensor> find(std::string_view name) const {
    for (size_t i = 0; i < size(); ++i)
      if ((*this)[i].info().name == name) return (*this)[i];
    return std::nullopt;
  }

 private:
  struct Free {
    void operator()(weir_results* results) const noexcept { weir_results_free(results); }
  };
  std::unique_ptr<weir_results, Free> results_;
};

struct ModelOptions {
  std::string engine = {};       // name or alias; "": chosen by the file names
  std::string accelerator = {};  // in the engine's terms; "": the engine's own choice
  int threads = 0;               // of one invoke; 0: the engine's own choice
  std::vector<std::pair<std::string, std::string>> options = {};  // the engine's: key, value
  std::chrono::nanoseconds timeout{0};                            // Model::set_timeout
  // The properties input, inputtype... of tensor_filter, for engines that need them.
  std::vector<std::pair<std::string, std::string>> declared = {};
};

class Model {
 public:
  // Opens a model of one file. Errors: MODEL_NOT_FOUND, ENGINE_UNKNOWN, ENGINE_NOT_INSTALLED,
  // errors of the engine.
  static Result<Model> open(const std::string& path, const ModelOptions& options = {}) {
    return open(std::span(&path, 1), options);
  }
  // Opens a model of several files.
  static Result<Model> open(std::span<const std::string> paths, const ModelOptions& options = {}) {
    std::vector<const char*> names;
    for (const auto& path : paths) names.push_back(path.c_str());
    std::vector<weir_option> pairs;
    for (const auto& [key, value] : options.options) pairs.push_back({key.c_str(), value.c_str()});
    std::vector<weir_option> declared;
    for (const auto& [key, value] : options.declared)
      declared.push_back({key.c_str(), value.c_str()});
    weir_model_options request = WEIR_MODEL_OPTIONS_INIT;
    request.paths = names.data();
    request.n_paths = static_cast<uint32_t>(names.size());
    request.engine = options.engine.c_str();
    request.accelerator = options.accelerator.c_str();
    request.options = pairs.data();
    request.n_options = static_cast<uint32_t>(pairs.size());
    request.threads = options.threads;
    request.timeout_ns = options.timeout.count();
    request.declared = declared.data();
    request.n_declared = static_cast<uint32_t>(declared.size());
    weir_loaded_model* model = nullptr;
    CError error;
    const int result = weir_model_open(&request, &model, error.place());
    if (result < 0) return error.take(result);
    return Model(model);
  }

  std::string engine() const { return weir_model_engine(model_.get()); }
  std::string engine_version() const { return weir_model_engine_version(model_.get()); }
  // Returns the metadata of the model file as a JSON object; "" without metadata.
  std::string metadata() const {
    const char* text = weir_model_metadata(model_.get());
    return text ? text : "";
  }
  // Return the current tensors; reshape() changes them.
  std::vector<TensorInfo> inputs() const {
    return infos(weir_model_input_count(model_.get()), weir_model_input);
  }
  std::vector<TensorInfo> outputs() const {
    return infos(weir_model_output_count(model_.get()), weir_model_output);
  }

  // Sets the shapes of all inputs where the model leaves them open, until the next reshape; an
  // empty shape keeps the model's. SPEC_MISMATCH for an extent that contradicts the model.
  Status reshape(std::span<const TensorShape> shapes) {
    std::vector<weir_tensor_info> wanted;
    for (const auto& shape : shapes)
      wanted.push_back(TensorView(nullptr, 0, WEIR_TYPE_END, shape).c_tensor().info);
    CError error;
    const int result = weir_model_reshape(model_.get(), wanted.data(),
                                          static_cast<uint32_t>(wanted.size()), error.place());
    if (result < 0) return error.take(result);
    return ok();
  }
  Status reshape(std::initializer_list<TensorShape> shapes) {
    return reshape(std::span(shapes.begin(), shapes.size()));
  }

  // Limits the duration of later calls; 0: no limit. With a limit, inputs are copied and the engine
  // runs on a thread of the model. An engine cannot be interrupted: after WORKER_TIMEOUT the invoke
  // continues in its own memory, and until it ends every call fails with WORKER_TIMEOUT.
  void set_timeout(std::chrono::nanoseconds timeout) noexcept {
    weir_model_set_timeout(model_.get(), timeout.count());
  }

  // Runs the model once. Errors name the tensor: SPEC_MISMATCH (number, type, shape), FRAME_SIZE,
  // INVOKE_FAILED, WORKER_TIMEOUT, errors of the engine.
  Result<Outputs> invoke(std::span<const TensorView> inputs) {
    const auto tensors = c_tensors(inputs);
    weir_results* results = nullptr;
    CError error;
    const int result =
        weir_model_invoke(model_.get(), tensors.data(), static_cast<uint32_t>(tensors.size()),
                          &results, error.place());
    if (result < 0) return error.take(result);
    return Outputs(results);
  }
  Result<Outputs> invoke(std::initializer_list<TensorView> inputs) {
    return invoke(std::span(inputs.begin(), inputs.size()));
  }

  // Writes into the caller's memory: one view per output, of exactly its size. Returns false when
  // the model has no output for these inputs.
  Result<bool> invoke_into(std::span<const TensorView> inputs,
                           std::span<const WritableTensorView> outputs) {
    const auto tensors = c_tensors(inputs);
    std::vector<weir_tensor> into;
    for (const auto& view : outputs) into.push_back(view.c_tensor());
    CError error;
    const int result =
        weir_model_invoke_into(model_.get(), tensors.data(), static_cast<uint32_t>(tensors.size()),
                               into.data(), static_cast<uint32_t>(into.size()), error.place());
    if (result < 0) return error.take(result);
    return result == 0;
  }
  Result<bool> invoke_into(std::initializer_list<TensorView> inputs,
                           std::initializer_list<WritableTensorView> outputs) {
    return invoke_into(std::span(inputs.begin(), inputs.size()),
                       std::span(outputs.begin(), outputs.size()));
  }

  // Runs several frames at once, for models whose outermost axis is open or has exactly this
  // length. Each frame holds all inputs in the shape of one frame. Outputs::of_frame returns the
  // results. BATCH_UNSUPPORTED if the model has no such axis or keeps state.
  Result<Outputs> invoke_batch(std::span<const std::vector<TensorView>> frames) {
    std::vector<weir_tensor> tensors;
    for (const auto& frame : frames)
      for (const auto& view : frame) tensors.push_back(view.c_tensor());
    weir_results* results = nullptr;
    CError error;
    const int result =
        weir_model_invoke_batch(model_.get(), tensors.data(), static_cast<uint32_t>(tensors.size()),
                                static_cast<uint32_t>(frames.size()), &results, error.place());
    if (result < 0) return error.take(result);
    return Outputs(results);
  }

 private:
  explicit Model(weir_loaded_model* model) : model_(model) {}
  template <class Describe>
  std::vector<TensorInfo> infos(uint32_t count, Describe describe) const {
    std::vector<TensorInfo> out;
    for (uint32_t i = 0; i < count; ++i) {
      weir_tensor_info info{};
      describe(model_.get(), i, &info);
      out.emplace_back(info);
    }
    return out;
  }
  static std::vector<weir_tensor> c_tensors(std::span<const TensorView> views) {
    std::vector<weir_tensor> out;
    for (const auto& view : views) out.push_back(view.c_tensor());
    return out;
  }

  struct Close {
    void operator()(weir_loaded_model* model) const noexcept { weir_model_close(model); }
  };
  std::unique_ptr<weir_loaded_model, Close> model_;
};

}  // namespace weir
