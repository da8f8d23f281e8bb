// OrtRunner: frames through an opened ONNX model, from and into the caller's memory.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <span>
#include <vector>

#include "onnxruntime/ort_model.hpp"

namespace weir::engine {

// Used by one thread at a time; several may share a model.
class OrtRunner {
 public:
  static Result<std::unique_ptr<OrtRunner>> create(const OrtModel& model,
                                                   std::span<const weir_option> options);

  // Output shapes: the model's names of open dimensions where they suffice, else a dry run on
  // zeros.
  Status resolve(std::span<const weir_tensor_info> in, std::span<weir_tensor_info> out);
  // Nothing is copied but bool inputs, which are made 0 or 1. An output without data gets memory of
  // ONNX Runtime, its shape and a release function.
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
  Status shape_of(const OrtValue* value, weir_tensor_info* info) const;
  // Runs on zeros of these shapes and puts the outputs' shapes into `out`.
  Status dry_run(std::span<const weir_tensor_info> in, std::span<weir_tensor_info> out);

  const OrtModel& model_;
  const OrtApi& api_;
  std::vector<weir_tensor_info> last_inputs_;  // of the last resolve, for WARM
  // One entry per input and output; the pointer arrays are what Run takes.
  std::vector<Value> inputs_, outputs_;
  std::vector<const OrtValue*> input_pointers_;
  std::vector<OrtValue*> output_pointers_;
  std::vector<std::vector<uint8_t>> bools_;  // normalised copies of bool inputs
};

}  // namespace weir::engine
