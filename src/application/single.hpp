// Single: a model that a program opened through the C API.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <mutex>
#include <string>
#include <variant>
#include <vector>

#include "capi-nnstreamer/nnstreamer-single.h"
#include "core/infer/queue/call_gate.hpp"
#include "ml_error.hpp"
#include "tensors_data.hpp"
#include "weir/model.h"

namespace weir::application {

using DataCallback = int (*)(const ml_tensors_data_h data, void* user_data);

struct SingleRequest {
  std::string model, custom;
  TensorSpecs inputs, outputs;  // none: as the model gives them
  std::string framework;        // "": chosen by the model's files
  ml_nnfw_type_e type = ML_NNFW_TYPE_ANY;
  std::string accelerator = "default";
  DataCallback callback = nullptr;  // gets the outputs of each invoke
  void* callback_data = nullptr;
};

// Thread-safe.
class Single : public Object {
 public:
  static constexpr const char* kKind = "single";
  template <class T>
  using Outcome = std::variant<T, Refusal>;
  using Done = std::monostate;

  // Checks the request in NNStreamer's order, then opens the model
  // (docs/compatibility/app-api.md 8.7).
  static Outcome<std::shared_ptr<Single>> open(SingleRequest request);
  const char* kind() const noexcept override { return kKind; }
  // Calls enter it; ml_single_close closes it.
  infer::CallGate& gate() noexcept { return gate_; }

  TensorSpecs inputs() const;
  TensorSpecs outputs() const;
  Outcome<Done> set_inputs(const TensorSpecs& wanted);
  void set_timeout(unsigned ms) noexcept;
  Outcome<std::shared_ptr<TensorsData>> invoke(const TensorsData& input);
  Outcome<Done> invoke_into(const TensorsData& input, const TensorsData& output);
  // Sets the inputs, which stay if the model accepts the frame.
  Outcome<std::shared_ptr<TensorsData>> invoke_dynamic(const TensorsData& input,
                                                       const TensorSpecs& inputs);

  // ML_ERROR_NOT_SUPPORTED: there is no such property.
  Outcome<std::string> property(const std::string& name) const;
  Outcome<Done> set_property(const std::string& name, const std::string& value);
  const SingleRequest& request() const noexcept { return request_; }

 private:
  using Model = std::shared_ptr<weir_loaded_model>;
  Single(Model model, SingleRequest request);
  static Result<Model> load(const SingleRequest& request, bool resizable);
  Status agree() const;
  Outcome<Done> replace_model(const TensorSpecs& wanted);
  // Requires inputs_mutex_.
  Outcome<Done> change_inputs(const TensorSpecs& wanted);
  using Infos = std::vector<weir_tensor_info>;
  void restore(const Model& model, const Infos& declared, Infos infos);
  // Sets the inputs that an invoke which timed out has kept from being restored. Requires
  // inputs_mutex_.
  Status restore_pending();
  Outcome<std::shared_ptr<TensorsData>> run(const TensorsData& input);
  Model model() const;

  const SingleRequest request_;
  bool has_open_inputs_ = false;  // the model's file leaves shapes open
  infer::CallGate gate_;
  std::mutex inputs_mutex_;   // held while the inputs change; taken before mutex_
  mutable std::mutex mutex_;  // guards the rest
  Model model_;
  unsigned timeout_ms_ = 0;
  // The inputs of model_ as its file has them, with what it leaves open; guarded by inputs_mutex_.
  Infos declared_;
  Infos pending_;  // none: the inputs of model_ are set; guarded by mutex_, written under both
};

}  // namespace weir::application
