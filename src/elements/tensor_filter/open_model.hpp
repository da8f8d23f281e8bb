// OpenModel: the open model of one tensor_filter, maybe shared with others, and its negotiation.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/filter/described_model.hpp"
#include "core/infer/batch/model_batches.hpp"
#include "core/infer/model/model_table.hpp"
#include "core/isolate/isolation.hpp"
#include "elements/tensor_filter/fallback.hpp"
#include "elements/tensor_filter/filter_plan.hpp"
#include "elements/tensor_filter/filter_settings.hpp"
#include "gstcpp/buffer/allocation.hpp"

namespace weir {

class OpenModel {
 public:
  // Finds the engine, opens the model or shares an open one, and applies the user's settings to its
  // description. With a `monitor` the model is opened in worker processes. `warnings` gets the
  // warnings for the user.
  static Result<std::unique_ptr<OpenModel>> open(const FilterSettings& settings,
                                                 std::shared_ptr<isolate::Monitor> monitor,
                                                 std::vector<Error>* warnings);

  const std::vector<ModelTensor>& inputs() const noexcept { return description_.inputs; }
  const std::vector<ModelTensor>& outputs() const noexcept { return description_.outputs; }
  const std::string& engine() const noexcept { return engine_; }
  // The allocation with which the model reads inputs without a copy.
  gst::Allocation allocation() const noexcept;

  // The plan for a stream of these caps, with the same rate. Call while no frame is in progress.
  Result<FilterPlan> plan_for(const FrameSpec& input) const;
  const ModelDescription& description() const noexcept { return description_; }

  // The sessions for one frame. Call in the order of the frames and keep the result until the
  // invoke has ended. Opens a suspended model again.
  Result<infer::ModelLease::Frame> begin() const { return use_->begin(); }
  // `plan` with inputs of these shapes and the outputs that the session resolves for them. Call
  // while `frame` is held.
  Result<FilterPlan> plan_for_shapes(FilterPlan plan, const infer::ModelLease::Frame& frame,
                                     size_t session, std::vector<ModelTensor> inputs) const;

  // The description of the model that is sent downstream, and how often the model was replaced by
  // then. Opens a suspended model again.
  Result<DescribedModel> described(const FilterPlan& plan) const;
  uint64_t reloads() const { return use_->shared()->reloads(); }
  // Replaces the model by that of `settings` for all filters that share it. Any thread.
  Status replace(const FilterSettings& settings) const;
  // The number of frames to process at a time: the property `workers`, or for 1, the default, as
  // many as the engine asks for.
  uint32_t workers() const noexcept { return workers_; }
  // The second model, for frames without a result; null if the user set none.
  Fallback* fallback() const noexcept { return fallback_.get(); }
  // Suspends the model, unless it runs batches. False while a frame is in progress.
  bool suspend() const { return batch_size_ > 1 || use_->suspend(); }
  // Adds weights-bytes, shared-by (the number of filters that share the weights), reloads,
  // suspended.
  void add_stats(GstStructure* stats) const;

 private:
  Status open_lease(const FilterSettings& settings, std::vector<Error>* warnings);
  Status open_lease_of(const infer::ModelSource& source, const FilterSettings& settings,
                       std::vector<Error>* warnings);
  Result<ModelTensors> read_tensors(const infer::Model& model, const FilterSettings& settings);
  Status fit_inputs(const std::vector<TensorSpec>& stream, FilterPlan* plan) const;
  Status resolve_outputs(FilterPlan* plan) const;
  Result<std::vector<ModelTensor>> resolve(
      const std::vector<ModelTensor>& inputs,
      const std::function<Result<std::vector<ModelTensor>>(const std::vector<ModelTensor>&)>&
          session) const;
  Status plan_batch(const FrameSpec& input, FilterPlan* plan) const;
  Status read_invocation(const infer::Session& session) const;
  bool is_dynamic() const noexcept { return description_.declared.invoke_dynamic; }

  std::string engine_;
  std::shared_ptr<isolate::Monitor> monitor_;  // null: the engine runs in this process
  std::unique_ptr<Fallback> fallback_;
  std::unique_ptr<infer::ModelLease> use_;
  uint32_t workers_ = 1;
  size_t batch_size_ = 1;
  infer::RowLimits rows_;
  infer::BatchAxes batch_axes_;  // if batch_size_ > 1
  ModelDescription description_;
  gst::Ref<GstAllocator> shared_memory_;  // memory that worker processes read; null = none
  bool asynchronous_ = false;
  bool decides_sizes_ = false;  // the model decides output sizes with each frame
  bool allocates_ = false;      // the engine allocates outputs and passes them on
};

}  // namespace weir
