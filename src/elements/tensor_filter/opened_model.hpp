// OpenedModel: the model behind one tensor_filter, maybe shared with others, and its negotiation.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "core/infer/model_batches.hpp"
#include "core/infer/model_table.hpp"
#include "core/isolate/isolation.hpp"
#include "elements/tensor_filter/filter_plan.hpp"
#include "elements/tensor_filter/filter_settings.hpp"
#include "gstcpp/allocation.hpp"

namespace weir {

class OpenedModel {
 public:
  // Finds the engine, opens the model or shares one that is open, lays the user's settings over
  // what the model says. With a `monitor` the model is opened in worker processes. `warnings` gets
  // what the user should know.
  static Result<std::unique_ptr<OpenedModel>> open(const FilterSettings& settings,
                                                   std::shared_ptr<isolate::Monitor> monitor,
                                                   std::vector<Error>* warnings);

  const std::vector<ModelShape>& inputs() const noexcept { return inputs_; }
  const std::vector<ModelShape>& outputs() const noexcept { return outputs_; }
  const std::string& engine() const noexcept { return engine_; }
  // How memory for inputs is best allocated: the model takes it without a copy.
  gst::Allocation allocation() const noexcept;

  // The plan for a stream of these caps; the rate is passed on. While no frame is in work.
  Result<FilterPlan> plan_for(const FrameSpec& input) const;
  // The tensors that leave the filter, as far as they are known before negotiation.
  std::vector<TensorSpec> known_outputs() const;
  // The user wants flexible outputs; engines that answer with any number of outputs.
  bool is_dynamic() const noexcept { return dynamic_; }
  bool is_asynchronous() const noexcept { return asynchronous_; }
  bool combines_inputs() const noexcept { return !input_choice_.empty(); }

  // The sessions of one frame: called in the order of the frames, kept until the frame's invoke has
  // ended. Opens again what was suspended.
  Result<infer::ModelUse::Frame> begin() const { return use_->begin(); }
  // The outputs for inputs of these shapes, within a frame.
  Result<std::vector<ModelShape>> resolve(const infer::ModelUse::Frame& frame, size_t worker,
                                          const std::vector<ModelShape>& inputs) const;

  // Puts the model of `settings` in place of this one, for all that share it. Any thread.
  Status replace(const FilterSettings& settings) const;
  // False while a frame is in work. A model of batches stays as it is.
  bool suspend() const { return batch_size_ > 1 || use_->suspend(); }
  // weights-bytes, shared-by (users, who have them once together), reloads, suspended.
  void add_stats(GstStructure* stats) const;

 private:
  Status read_tensors(const infer::Model& model, const FilterSettings& settings);
  Status plan_batch(const FrameSpec& input, FilterPlan* plan) const;
  Status read_combinations(const FilterSettings& settings);
  Status check_choice(const std::vector<ModelShape>& outputs) const;
  // What the engine says of its outputs for a stream, with what the user says of those it leaves
  // open. SPEC_MISMATCH where the user contradicts it.
  Result<std::vector<ModelShape>> complete(std::vector<ModelShape> resolved) const;
  Status read_invocation(const infer::Session& session) const;

  std::string engine_;
  std::shared_ptr<isolate::Monitor> monitor_;  // null: the engine runs in this process
  std::unique_ptr<infer::ModelUse> use_;
  size_t batch_size_ = 1;
  infer::RowLimits rows_;
  infer::BatchAxes batch_axes_;               // where batch_size_ > 1
  std::vector<ModelShape> inputs_, outputs_;  // of one frame
  std::string output_, outputtype_;           // as the user has them
  std::vector<size_t> input_choice_;
  OutputCombination output_choice_;
  gst::Ref<GstAllocator> shared_memory_;  // where worker processes read; null = none do
  bool dynamic_ = false, asynchronous_ = false;
  bool decides_sizes_ = false;  // the model says so: with each frame anew
  bool allocates_ = false;      // the engine has memory of its own for outputs, and gives it away
};

}  // namespace weir
