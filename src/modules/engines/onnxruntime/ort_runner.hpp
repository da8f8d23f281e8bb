// OrtRunner: runs an open ONNX model on frames, directly on the caller's memory.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <span>
#include <vector>

#include "onnxruntime/ort_model.hpp"

namespace weir::engine {

// One thread at a time; several runners may share a model.
class OrtRunner {
 public:
  static Result<std::unique_ptr<OrtRunner>> create(const OrtModel& model,
                                                   std::span<const weir_option> options);

  // Resolves output shapes by the names of open dimensions if they suffice, otherwise by a dry run
  // on zeros.
  Status resolve(std::span<const weir_tensor_info> in, std::span<weir_tensor_info> out);
  // Copies only bool inputs, to normalise them to 0 or 1. An output without data gets ONNX
  // Runtime's memory, its shape and a release function.
  Status invoke(const weir_frame& in, weir_frame& out);
  Status warm();

 private:
  explicit OrtRunner(const OrtModel& model);
  using Value = OrtOwner<OrtValue>;

  Status bind_inputs(const weir_frame& in);
  Status bind_outputs(const weir_frame& out);
  Status run();
  Status hand_over(const weir_frame& in, weir_frame& out);
  Status hand_over(const weir_frame& in, size_t index, weir_tensor* tensor);
  void unbind() noexcept;
  Result<Value> wrap(void* data, const weir_tensor_info& info, uint64_t bytes,
                     ONNXTensorElementDataType type) const;
  Status get_shape(const OrtValue* value, weir_tensor_info* info) const;
  // Runs on zeros of these shapes and stores the outputs' shapes in `out`.
  Status dry_run(std::span<const weir_tensor_info> in, std::span<weir_tensor_info> out);

  const OrtModel& model_;
  const OrtApi& api_;
  std::vector<weir_tensor_info> last_inputs_;  // inputs of the last resolve, for WEIR_WARM
  // One entry per input and output; Run takes the pointer arrays.
  std::vector<Value> inputs_, outputs_;
  std::vector<const OrtValue*> input_pointers_;
  std::vector<OrtValue*> output_pointers_;
  std::vector<std::vector<uint8_t>> bools_;  // normalised copies of bool inputs
};

}  // namespace weir::engine
