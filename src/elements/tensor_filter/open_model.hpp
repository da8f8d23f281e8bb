// OpenModel: the open model of one tensor_filter, maybe shared with others, and its negotiation,
// whose result is a FilterPlan.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/filter/combination.hpp"
#include "core/filter/described_model.hpp"
#include "core/filter/model_fit.hpp"
#include "core/infer/batch/batch_group.hpp"
#include "core/infer/batch/model_batches.hpp"
#include "core/infer/batch/row_runner.hpp"
#include "core/infer/model/model_table.hpp"
#include "core/isolate/isolation.hpp"
#include "core/limit/buffer_limit.hpp"
#include "elements/tensor_filter/fallback.hpp"
#include "elements/tensor_filter/filter_settings.hpp"
#include "gstcpp/buffer/allocation.hpp"
#include "gstcpp/pads/upstream_medium.hpp"

namespace weir {

// How the frames of a stream are processed, from its caps until the next ones.
struct FilterPlan {
  FrameSpec input;                   // of the sink pad
  FrameSpec output;                  // of the source pad
  std::vector<size_t> input_choice;  // stream tensors given to the model; empty = all
  OutputCombination output_choice;   // empty = all model outputs
  std::vector<ModelTensor>
      declared_inputs;  // from the model and the properties; may be partly unknown
  std::vector<ModelTensor> model_inputs;   // exact shapes, fixed when input is static
  std::vector<ModelTensor> model_outputs;  // exact shapes; may be partly unknown
  bool outputs_fixed = false;              // every output size is known before the invoke
  bool engine_allocates = false;  // even if outputs_fixed: the engine decides for each frame
  bool dynamic = false;           // invoke-dynamic: headers have format flexible
  size_t alignment = 1;           // bytes, of each of the model's inputs
  size_t padding = 0;             // readable bytes after each
  size_t fallback_alignment = 1, fallback_padding = 0;  // what the fallback needs as well
  std::shared_ptr<infer::BatchGroup> batch;             // null: one invoke for each frame
  infer::RowLimits rows;                                // of one invoke
  gst::Medium medium = gst::Medium::Unknown;            // of which the stream was made
  const BufferLimit* limit = nullptr;                   // of each output; borrowed from the element

  // Whether the engine writes into pooled memory.
  bool has_memory() const noexcept { return outputs_fixed && !engine_allocates; }
  // The format in the header of each tensor of a flexible stream.
  Format header_format() const noexcept { return dynamic ? Format::Flexible : Format::Static; }
};

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

  // Its sessions. Call begin() in the order of the frames and keep the result until the invoke has
  // ended.
  infer::ModelLease& lease() const noexcept { return *lease_; }
  // `plan` with inputs of these shapes and the outputs that the session resolves for them. Call
  // while `frame` is held.
  Result<FilterPlan> plan_for_shapes(FilterPlan plan, const infer::ModelLease::Frame& frame,
                                     size_t session, std::vector<ModelTensor> inputs) const;

  // The description of the model that is sent downstream, and how often the model was replaced by
  // then. Opens a suspended model again.
  Result<DescribedModel> described(const FilterPlan& plan) const;
  // Replaces the model by that of `settings` for all filters that share it. Any thread.
  Status replace(const FilterSettings& settings) const;
  // The number of frames to process at a time: the property `workers`, or for 1, the default, as
  // many as the engine asks for.
  uint32_t workers() const noexcept { return workers_; }
  // The second model, for frames without a result; null if the user set none.
  Fallback* fallback() const noexcept { return fallback_.get(); }
  // Whether inputs may have no elements. A replaced model may differ.
  bool takes_empty() const;
  // Suspends the model, unless it runs batches. False while a frame is in progress.
  bool suspend() const { return batch_size_ > 1 || lease_->suspend(); }
  // Adds weights-bytes, shared-by (the number of filters that share the weights), reloads,
  // suspended.
  void add_stats(GstStructure* stats) const;

 private:
  Status open_lease(const FilterSettings& settings, std::vector<Error>* warnings);
  Status open_lease(const infer::ModelConfig& source, const FilterSettings& settings,
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
  std::unique_ptr<infer::ModelLease> lease_;
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
