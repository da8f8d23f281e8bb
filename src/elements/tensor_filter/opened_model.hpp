// OpenedModel: the engine, model and session behind one tensor_filter, and its negotiation.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "core/infer/model.hpp"
#include "elements/tensor_filter/filter_plan.hpp"
#include "elements/tensor_filter/filter_settings.hpp"
#include "gstcpp/allocation.hpp"

namespace weir {

class OpenedModel {
 public:
  // Finds the engine, opens the model, lays the user's settings over what the model says.
  static Result<std::unique_ptr<OpenedModel>> open(const FilterSettings& settings);

  const std::vector<ModelShape>& inputs() const noexcept { return inputs_; }
  const std::vector<ModelShape>& outputs() const noexcept { return outputs_; }
  const std::string& engine() const noexcept { return engine_; }
  infer::Session* session() const noexcept { return session_.get(); }
  // How memory for inputs is best allocated: the model takes it without a copy.
  gst::Allocation allocation() const noexcept;

  // The plan for a stream of these caps; the rate is passed on.
  Result<FilterPlan> plan_for(const FrameSpec& input) const;
  // The tensors that leave the filter, as far as they are known before negotiation.
  std::vector<TensorSpec> known_outputs() const;
  bool combines_inputs() const noexcept { return !input_choice_.empty(); }

 private:
  Status read_combinations(const FilterSettings& settings);

  std::string engine_;
  std::shared_ptr<infer::Model> model_;
  std::unique_ptr<infer::Session> session_;
  std::vector<ModelShape> inputs_, outputs_;
  std::vector<size_t> input_choice_;
  OutputCombination output_choice_;
};

}  // namespace weir
