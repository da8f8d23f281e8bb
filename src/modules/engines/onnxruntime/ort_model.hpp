// OrtModel: an ONNX model opened by ONNX Runtime, with its inputs and outputs.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "model_bytes.hpp"
#include "onnxruntime/onnx_file.hpp"
#include "onnxruntime/ort_api.hpp"
#include "onnxruntime/ort_arena.hpp"
#include "onnxruntime/ort_options.hpp"
#include "onnxruntime/own_prelu.hpp"
#include "weir/abi.h"

namespace weir::engine {

// The inputs or the outputs of a model, in the model's order.
struct OrtPorts {
  std::vector<std::string> names;
  std::vector<weir_tensor_info> infos;  // their names point into `names`
  std::vector<ONNXTensorElementDataType> types;
  std::vector<std::vector<std::string>> symbols;  // per dimension, "" = none
  std::vector<const char*> name_pointers;
};

class OrtModel {
 public:
  static Result<std::unique_ptr<OrtModel>> open(const weir_open& request);
  OrtModel(const OrtModel&) = delete;
  OrtModel& operator=(const OrtModel&) = delete;

  void describe(weir_model_info* info) const;
  weir_execution execution() const noexcept {
    return {sizeof(weir_execution), static_cast<uint32_t>(threads_), spins_};
  }

  const OrtRuntime& runtime() const noexcept { return *runtime_; }
  OrtSession* session() const noexcept { return session_.get(); }
  const OrtPorts& inputs() const noexcept { return inputs_; }
  const OrtPorts& outputs() const noexcept { return outputs_; }
  bool shapes_depend_on_data() const noexcept { return shapes_depend_on_data_; }

 private:
  explicit OrtModel(std::shared_ptr<const OrtRuntime> runtime);
  Status take_own_operators(const OrtOptions& options, const OnnxSummary& summary,
                            ModelBytes* file);
  // Reads inputs and outputs.
  Status read_session(const OnnxSummary& summary);
  Status create_session(const ModelBytes& file, const OrtOptions& options);
  Result<OrtPorts> read_ports(bool inputs, const OnnxSummary& summary) const;
  Status read_port(const OrtTypeInfo& type, const OnnxSummary& summary, OrtPorts* ports) const;
  Status read_shape(const OrtTensorTypeAndShapeInfo& tensor, bool shapeless, weir_tensor_info* info,
                    std::vector<std::string>* symbols) const;
  void mark_batch_axis();

  std::shared_ptr<const OrtRuntime> runtime_;  // must outlive the session
  std::shared_ptr<const OrtArena> arena_;      // must outlive the session
  std::shared_ptr<const OwnOperators>
      own_;  // must outlive the session; null without such operators
  OrtOwner<OrtSession> session_;
  OrtPorts inputs_, outputs_;
  bool shapes_depend_on_data_ = false;
  uint64_t weight_bytes_ = 0;
  int threads_ = 1;
  bool spins_ = false;
  std::string metadata_;
};

}  // namespace weir::engine
