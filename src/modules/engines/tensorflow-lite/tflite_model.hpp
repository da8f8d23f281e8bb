// TfliteModel: a TensorFlow Lite model, checked and opened, with its inputs and outputs.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "tensorflow-lite/tflite_interpreter.hpp"
#include "tflite-file/tflite_file.hpp"
#include "weir/execution.h"

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
  // For the model's own shapes when `shapes` is empty.
  Result<std::unique_ptr<TfliteInterpreter>> interpreter(
      std::span<const weir_tensor_info> shapes) const;
  // For a session, of the model's own shapes: the first gets the one that opening needed.
  Result<std::unique_ptr<TfliteInterpreter>> session_interpreter() const;

 private:
  explicit TfliteModel(const TfliteApi& api);
  Status read_tensors(const TfliteInterpreter& interpreter);

  const TfliteApi& api_;
  std::vector<std::byte>
      bytes_;  // the file; TensorFlow Lite reads weights there as long as it lives
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

// What an interpreter says of a tensor now. MODEL_UNSUPPORTED for types that streams lack.
Result<weir_tensor_info> tflite_tensor_info(const TfliteApi& api, const TfLiteTensor& tensor);
// Its size is not known before an invoke.
bool is_unallocated(const TfLiteTensor& tensor) noexcept;

}  // namespace weir::engine
