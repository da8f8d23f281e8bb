// TfliteInterpreter: one interpreter of a model for one set of input shapes, ready to invoke.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "tensorflow-lite/tflite_api.hpp"
#include "tensorflow-lite/tflite_options.hpp"
#include "weir/abi.h"

namespace weir::engine {

class TfliteInterpreter {
 public:
  // `shapes`: those of all inputs; empty = the model's own. Uses the XNNPACK delegate if it is
  // requested and accepts the graph. `model` must outlive this. MODEL_UNSUPPORTED for operators
  // that the library lacks; SPEC_MISMATCH for shapes that the model rejects; MODEL_INVALID
  // otherwise.
  static Result<std::unique_ptr<TfliteInterpreter>> create(
      const TfliteApi& api, const TfLiteModel* model, const TfliteOptions& options,
      std::span<const weir_tensor_info> shapes);
  TfliteInterpreter(const TfliteInterpreter&) = delete;
  TfliteInterpreter& operator=(const TfliteInterpreter&) = delete;

  size_t inputs() const;
  size_t outputs() const;
  TfLiteTensor* input(size_t index) const;
  const TfLiteTensor* output(size_t index) const;
  bool delegated() const noexcept { return delegate_ != nullptr; }

  Status invoke();
  void reset_state();

 private:
  using Delegate = std::unique_ptr<TfLiteDelegate, void (*)(TfLiteDelegate*)>;
  using Interpreter = std::unique_ptr<TfLiteInterpreter, void (*)(TfLiteInterpreter*)>;

  explicit TfliteInterpreter(const TfliteApi& api);
  Status build(const TfLiteModel* model, const TfliteOptions& options, bool delegate,
               std::span<const weir_tensor_info> shapes);
  Status resize(std::span<const weir_tensor_info> shapes);
  bool delegate_graph(int threads);
  static void report(void* self, const char* format, va_list arguments);

  const TfliteApi& api_;
  std::string reported_errors_;  // messages of the library since it was cleared
  Delegate delegate_;            // must outlive the interpreter
  Interpreter interpreter_;
};

}  // namespace weir::engine
