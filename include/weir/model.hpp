// A model of any engine, opened and invoked by a program itself, with no pipeline around it.
// Over model.h: link with libweir (pkg-config weir).
//
//   auto model = weir::Model::open("mobilenet.onnx");
//   if (!model) return complain(model.error().message());
//   auto outputs = model->invoke({std::span<const uint8_t>(pixels)});
//   auto scores = outputs ? (*outputs)[0].as<float>() : outputs.error();
//
// Any thread may call; calls of one model wait for each other. After a move the object left behind
// may only be assigned to or destroyed.
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

// What an invoke gave. Owns the memory; may outlive its model.
class Outputs {
 public:
  // Nothing is in it when the model gave nothing for these inputs: dropped().
  explicit Outputs(weir_results* results = nullptr) : results_(results) {}
  bool dropped() const noexcept { return !results_; }
  size_t size() const noexcept { return results_ ? weir_results_count(results_.get()) : 0; }
  size_t frames() const noexcept { return results_ ? weir_results_frames(results_.get()) : 0; }
  // Output `index` of all frames; `index` below size(). Lives as long as this object.
  Tensor operator[](size_t index) const noexcept {
    weir_tensor tensor{};
    if (results_) weir_results_tensor(results_.get(), static_cast<uint32_t>(index), &tensor);
    return Tensor(tensor);
  }
  // The part of one frame of a batch; `frame` below frames().
  Tensor of_frame(size_t frame, size_t index) const noexcept {
    weir_tensor tensor{};
    if (results_)
      weir_results_frame_tensor(results_.get(), static_cast<uint32_t>(frame),
                                static_cast<uint32_t>(index), &tensor);
    return Tensor(tensor);
  }
  // By name; nullopt when there is none of it.
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
  std::string engine = {};       // name or alias; "": by the names of the files
  std::string accelerator = {};  // what the engine calls it; "": the engine's own choice
  int threads = 0;               // inside one invoke; 0: the engine's own choice
  std::vector<std::pair<std::string, std::string>> options = {};  // the engine's: key, value
  std::chrono::nanoseconds timeout{0};                            // Model::set_timeout
  // What the properties input, inputtype... of tensor_filter would say, for engines that ask.
  std::vector<std::pair<std::string, std::string>> declared = {};
};

class Model {
 public:
  // MODEL_NOT_FOUND, ENGINE_UNKNOWN, ENGINE_NOT_INSTALLED, what the engine says.
  static Result<Model> open(const std::string& path, const ModelOptions& options = {}) {
    return open(std::span(&path, 1), options);
  }
  // Of several files.
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
  // What the model's file says of itself, a JSON object; "" when it says nothing.
  std::string metadata() const {
    const char* text = weir_model_metadata(model_.get());
    return text ? text : "";
  }
  // As they are now: reshape() changes them.
  std::vector<TensorInfo> inputs() const {
    return infos(weir_model_input_count(model_.get()), weir_model_input);
  }
  std::vector<TensorInfo> outputs() const {
    return infos(weir_model_output_count(model_.get()), weir_model_output);
  }

  // Shapes of all inputs in place of what the model leaves open, until the next reshape; an empty
  // one: as the model says. SPEC_MISMATCH where the model has another extent.
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

  // How long a later call may take; 0: without limit. With a limit inputs are copied and the engine
  // runs on a thread of the model. No engine can be stopped from outside: after WORKER_TIMEOUT the
  // invoke goes on by itself, in memory of its own, and every call is WORKER_TIMEOUT until it ends.
  void set_timeout(std::chrono::nanoseconds timeout) noexcept {
    weir_model_set_timeout(model_.get(), timeout.count());
  }

  // Once. SPEC_MISMATCH (number, type, shape), FRAME_SIZE, INVOKE_FAILED, WORKER_TIMEOUT, what the
  // engine says; named by the tensor.
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

  // Into the caller's memory: a view of writable elements for each output, of exactly its size.
  // False: the model gives nothing for these inputs.
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

  // Several frames at once, for models whose outermost axis is open (or just that long); each
  // frame holds all inputs, with the shape of one frame. Outputs::of_frame has the answers.
  // BATCH_UNSUPPORTED where the model has no such axis or keeps state.
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
