// DnnModel: a Caffe, TensorFlow or Darknet network that OpenCV opened, with its inputs and outputs.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "opencv-dnn/dnn_net.hpp"
#include "weir/abi.h"

namespace weir::engine {

// The engine of this module, defined next to its entry point.
struct DnnEngine {
  DnnFormat format;
  const char *name, *description_extension, *weights_extension;
};
extern const DnnEngine dnn_engine;

class DnnModel {
 public:
  static Result<std::unique_ptr<DnnModel>> open(const weir_open& request);
  DnnModel(const DnnModel&) = delete;
  DnnModel& operator=(const DnnModel&) = delete;

  void describe(weir_model_info* info) const;

  weir_execution execution() const;

  const std::vector<weir_tensor_info>& inputs() const noexcept { return inputs_; }
  const std::vector<weir_tensor_info>& outputs() const noexcept { return outputs_; }
  // Runs the network once and returns outputs in its memory. One thread at a time: the model has
  // only one session.
  Result<std::vector<DnnOutput>> run(std::span<const weir_tensor> in) const;
  // Finds the outputs for inputs of these shapes by running on zeros.
  Result<std::vector<weir_tensor_info>> dry_run(std::span<const weir_tensor_info> in) const;

 private:
  DnnModel() = default;
  Status read_options(const weir_open& request);
  bool is_small() const;
  Status read_inputs(const DnnDescription& description);
  Status name_outputs(const DnnDescription& description);
  Status read_outputs(const DnnDescription& description);

  int threads_ = 1;
  bool keeps_threads_ = false;  // the user gave NumThreads: each run has this number
  DeclaredTensors declared_;
  std::unique_ptr<DnnNet> net_;
  std::vector<std::string> input_names_, output_names_;
  std::vector<weir_tensor_info> inputs_, outputs_;
  std::unique_ptr<bool[]> pictures_;  // per output: is it NHWC
  bool nhwc_ = false;
  uint64_t weight_bytes_ = 0;
  std::string metadata_;
};

}  // namespace weir::engine
