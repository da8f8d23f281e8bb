// Single: a model that a program opened through the C API.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <string>

#include "capi-nnstreamer/nnstreamer-single.h"
#include "tensors_data.hpp"
#include "weir/model.h"

namespace weir::application {

struct SingleRequest {
  std::string model, custom;
  TensorSpecs inputs, outputs;  // none: as the model gives them
  ml_nnfw_type_e framework = ML_NNFW_TYPE_ANY;
  ml_nnfw_hw_e hardware = ML_NNFW_HW_ANY;
};

// Thread-safe.
class Single : public Object {
 public:
  static constexpr const char* kKind = "single";
  // Errors of weir_model_open; SPEC_MISMATCH when model and request differ.
  static Result<std::shared_ptr<Single>> open(const SingleRequest& request);
  const char* kind() const noexcept override { return kKind; }

  TensorSpecs inputs() const;
  TensorSpecs outputs() const;
  Status set_inputs(const TensorSpecs& wanted);
  void set_timeout(unsigned ms) noexcept;
  // `shapes` replace the shapes of the inputs; empty: unchanged.
  Result<std::shared_ptr<TensorsData>> invoke(const TensorsData& input,
                                              const TensorSpecs& shapes = {});
  Status invoke_into(const TensorsData& input, const TensorsData& output);

  Result<std::string> property(const std::string& name) const;
  Status set_property(const std::string& name, const std::string& value);

 private:
  struct Close {
    void operator()(weir_loaded_model* model) const noexcept { weir_model_close(model); }
  };
  Single(weir_loaded_model* model, SingleRequest request, std::string accelerator)
      : model_(model), request_(std::move(request)), accelerator_(std::move(accelerator)) {}
  Status agree() const;
  std::vector<weir_tensor> fitted(const TensorsData& input, const TensorSpecs& shapes) const;

  std::unique_ptr<weir_loaded_model, Close> model_;
  const SingleRequest request_;
  const std::string accelerator_;
};

}  // namespace weir::application
