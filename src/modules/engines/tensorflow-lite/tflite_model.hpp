// TfliteModel: a TensorFlow Lite model, validated and opened, with its inputs and outputs.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "tensorflow-lite/tflite_interpreter.hpp"
#include "tflite-file/tflite_file.hpp"
#include "weir/abi.h"

namespace weir::engine {

class TfliteModel {
 public:
  static Result<std::unique_ptr<TfliteModel>> open(const weir_open& request);
  TfliteModel(const TfliteModel&) = delete;
  TfliteModel& operator=(const TfliteModel&) = delete;

  void describe(weir_model_info* info) const;
  weir_execution execution() const noexcept {
    return {sizeof(weir_execution), static_cast<uint32_t>(options_.threads), 0};
  }

  const std::vector<weir_tensor_info>& inputs() const noexcept { return inputs_; }
  const std::vector<weir_tensor_info>& outputs() const noexcept { return outputs_; }
  const TfliteSummary& summary() const noexcept { return summary_; }
  // An empty `shapes` means the model's own shapes.
  Result<std::unique_ptr<TfliteInterpreter>> interpreter(
      std::span<const weir_tensor_info> shapes) const;
  // For a session with the model's own shapes: the first gets the one created by open().
  Result<std::unique_ptr<TfliteInterpreter>> session_interpreter() const;

 private:
  explicit TfliteModel(const TfliteApi& api);
  Result<weir_tensor_info> read_tensor(const TfLiteTensor& tensor, bool is_input);
  Status read_tensors(const TfliteInterpreter& interpreter);

  const TfliteApi& api_;
  std::vector<std::byte>
      bytes_;  // the file; TensorFlow Lite reads weights there until it is closed
  std::unique_ptr<TfLiteModel, void (*)(TfLiteModel*)> model_;
  TfliteOptions options_;
  TfliteSummary summary_;
  std::vector<std::string> names_;
  std::vector<weir_tensor_info> inputs_, outputs_;  // their names point into names_
  std::string metadata_;
  bool packs_weights_ = false;
  mutable std::mutex first_mutex_;                    // guards first_
  mutable std::unique_ptr<TfliteInterpreter> first_;  // until a session takes it
};

// The interpreter's current description of a tensor. MODEL_UNSUPPORTED for types that streams lack.
Result<weir_tensor_info> tflite_tensor_info(const TfliteApi& api, const TfLiteTensor& tensor);
// True when the tensor's size is unknown before an invoke.
bool is_unallocated(const TfLiteTensor& tensor) noexcept;

}  // namespace weir::engine
