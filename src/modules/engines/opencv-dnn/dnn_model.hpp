// DnnModel: a Caffe, TensorFlow or Darknet network opened by OpenCV, with its inputs and outputs.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "opencv-dnn/dnn_net.hpp"

namespace weir::engine {

// Of this module; its entry says which.
struct DnnEngine {
  DnnFormat format;
  const char *name, *description_ending, *weights_ending;
};
extern const DnnEngine dnn_engine;

class DnnModel {
 public:
  static Result<std::unique_ptr<DnnModel>> open(const weir_open& request);
  DnnModel(const DnnModel&) = delete;
  DnnModel& operator=(const DnnModel&) = delete;

  void describe(weir_model_info* info) const;

  const std::vector<weir_tensor_info>& inputs() const noexcept { return inputs_; }
  const std::vector<weir_tensor_info>& outputs() const noexcept { return outputs_; }
  // One run on this memory. Used by one thread at a time: the model has one session.
  Result<std::vector<DnnOutput>> run(std::span<const weir_tensor> in) const;
  // The outputs for inputs of these shapes, by a run on zeros.
  Result<std::vector<weir_tensor_info>> dry_run(std::span<const weir_tensor_info> in) const;

 private:
  DnnModel() = default;
  Status read_options(const weir_open& request);
  Status read_inputs(const DnnDescription& description);
  Status read_outputs(const DnnDescription& description);

  int threads_ = 1;
  DeclaredTensors declared_;
  std::unique_ptr<DnnNet> net_;
  std::vector<std::string> input_names_, output_names_;
  std::vector<weir_tensor_info> inputs_, outputs_;
  std::unique_ptr<bool[]> pictures_;  // of outputs: NHWC
  bool nhwc_ = false;
  uint64_t weight_bytes_ = 0;
  std::string metadata_;
};

}  // namespace weir::engine
