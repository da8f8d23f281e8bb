// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_filter/open_model.hpp"

#include <algorithm>
#include <array>

#include "core/custom/custom_easy.hpp"
#include "core/infer/module/host.hpp"
#include "core/isolate/isolated_engine.hpp"
#include "elements/tensor_filter/model_config.hpp"
#include "elements/tensor_filter/model_report.hpp"
#include "gstcpp/buffer/allocation.hpp"

namespace weir {
namespace {

// Worker processes are not shared between filters.
std::string shared_key(const FilterSettings& s, std::vector<Error>* warnings) {
  if (s.isolate == IsolateChoice::None) return s.shared_tensor_filter_key.value_or("");
  if (s.shared_tensor_filter_key)
    warnings->push_back(
        {.code = Code::OPTION_VALUE,
         .what = "a model in a separate process is not shared",
         .offered = "isolate=process shared-tensor-filter-key=" + *s.shared_tensor_filter_key,
         .needed = "isolate=none, to share it"});
  return "";
}

infer::RowLimits get_row_limits(const FilterSettings& s) {
  return {s.invoke_rows, s.invoke_threads};
}

// Rejects settings with which a frame's batch cannot run in parts.
Status check_parts(const FilterSettings& s) {
  if (get_row_limits(s).none()) return ok();
  const auto other = [&](const std::string& what) {
    return Error{.code = Code::OPTION_VALUE,
                 .what = "these properties cannot be combined",
                 .offered = what + " with invoke-rows=" + std::to_string(s.invoke_rows) +
                            " invoke-threads=" + std::to_string(s.invoke_threads),
                 .needed = "one of them",
                 .fix = "tensor_filter invoke-rows=0 invoke-threads=1"};
  };
  if (s.batch_size > 1) return other("batch-size=" + std::to_string(s.batch_size));
  if (s.invoke_async) return other("invoke-async=true");
  if (s.isolate != IsolateChoice::None) return other("isolate=process");
  return ok();
}

// Batches have one session for all filters that share the model.
size_t count_sessions(const FilterSettings& s, std::vector<Error>* warnings) {
  if (s.batch_size > 1) return 0;
  if (!s.invoke_async) return size_t{s.workers} * s.invoke_threads;
  if (s.workers > 1)
    warnings->push_back(
        {.code = Code::OPTION_VALUE,
         .what = "workers has no effect, because the engine uses its own threads",
         .offered = "workers=" + std::to_string(s.workers) + " with invoke-async=true",
         .needed = "workers=1: the model decides how many frames may be in progress",
         .fix = "tensor_filter invoke-async=true workers=1"});
  return 1;
}

// The invokes at a time that the engine asks for, where the user did not choose; otherwise 1.
uint32_t parallel_invokes(const weir_model_info& info, const FilterSettings& s) {
  constexpr uint32_t kMax = 64;
  constexpr uint32_t kKinds = WEIR_MODEL_THREAD_SAFE | WEIR_MODEL_ASYNC | WEIR_MODEL_STATEFUL;
  const bool free =
      s.workers == 1 && s.batch_size == 1 && !s.invoke_async && get_row_limits(s).none();
  if (!free || (info.flags & kKinds) != WEIR_MODEL_THREAD_SAFE) return 1;
  return std::clamp(info.max_in_flight, 1u, kMax);
}

// Tensors with the shapes and names of `shapes` and the quantisation of the model's `infos`.
std::vector<ModelTensor> described_tensors(const std::vector<ModelTensor>& shapes,
                                           const std::vector<weir_tensor_info>& infos) {
  std::vector<ModelTensor> out;
  for (size_t i = 0; i < shapes.size(); ++i) {
    out.push_back(shapes[i]);
    const bool same = i < infos.size() && infos[i].type == static_cast<uint32_t>(shapes[i].type);
    out[i].scale = same ? infos[i].scale : 0;
    out[i].zero_point = same ? infos[i].zero_point : 0;
  }
  return out;
}

// The tensors that output-combination chooses.
std::vector<ModelTensor> pushed_tensors(const FilterPlan& plan,
                                        const std::vector<ModelTensor>& outputs) {
  std::vector<ModelTensor> pushed;
  for (const size_t index : plan.output_choice.inputs)
    pushed.push_back(index < plan.input.tensors.size() ? model_tensor(plan.input.tensors[index])
                                                       : ModelTensor{});
  for (const size_t index : plan.output_choice.outputs)
    if (index < outputs.size()) pushed.push_back(outputs[index]);
  return pushed;
}

void add(const std::optional<Error>& warning, std::vector<Error>* warnings) {
  if (warning) warnings->push_back(*warning);
}

// With invoke-rows=1 a model of one row runs once for each row.
infer::RowLimits get_row_limits(const FilterSettings& s, const infer::Model& model) {
  auto rows = get_row_limits(s);
  rows.single = s.invoke_rows == 1 &&
                infer::has_single_row(model.info().flags, model.inputs(), model.outputs());
  return rows;
}

Status check_rows(const infer::Model& model, const infer::RowLimits& rows) {
  if (rows.none() || rows.single) return ok();
  return infer::check_rows(model.info().flags, model.inputs(), model.outputs());
}

void set_rows(std::vector<ModelTensor>* shapes, int64_t rows) {
  for (ModelTensor& shape : *shapes) shape.shape.at(0) = rows;
}

}  // namespace

Result<std::unique_ptr<OpenModel>> OpenModel::open(const FilterSettings& s,
                                                   std::shared_ptr<isolate::Monitor> monitor,
                                                   std::vector<Error>* warnings) {
  if (auto status = check_parts(s); !status) return status.error();
  auto opened = std::make_unique<OpenModel>();
  opened->monitor_ = std::move(monitor);
  if (auto status = opened->open_lease(s, warnings); !status) return status.error();
  const auto frame = opened->lease_->begin();
  if (!frame) return frame.error();
  const infer::Model& model = frame->model();
  opened->engine_ = model.engine().name;
  if (auto arena = isolate::get_arena(model)) {
    opened->engine_ = isolate::engine_in(model);
    add(isolate::accelerator_in(model).warning, warnings);
    opened->shared_memory_ = gst::shared_allocator(std::move(arena));
  }
  if (auto status =
          custom::check_invocation(model.engine(), model.info(), s.model, s.invoke_dynamic);
      !status)
    return status.error();
  opened->rows_ = get_row_limits(s, model);
  auto tensors = opened->read_tensors(model, s);
  if (!tensors) return tensors.error();
  if (auto status = check_rows(model, opened->rows_); !status) return status.error();
  // NNStreamer's programs take a warning on the bus for a failure, and an unknown layout is none.
  std::vector<Error> ignored;
  auto description = describe_model(*std::move(tensors), s, &ignored);
  for (const auto& setting : ignored)
    infer::host().log(WEIR_LOG_WARNING, "filter", setting.message().c_str());
  if (!description) return description.error();
  opened->description_ = *std::move(description);
  if (opened->fallback_)
    if (auto status = opened->fallback_->check(opened->inputs(), opened->outputs()); !status)
      return status.error();
  opened->asynchronous_ = s.invoke_async;
  opened->decides_sizes_ = (model.info().flags & WEIR_MODEL_DYNAMIC_OUTPUT) != 0;
  // Worker processes do not pass on memory, and batches need memory for several frames.
  opened->allocates_ = (model.info().flags & WEIR_MODEL_ALLOCATES_OUTPUT) != 0 &&
                       !opened->monitor_ && s.batch_size == 1 &&
                       opened->outputs().size() <= kMemoryLimit;
  if (!s.invoke_async) return opened;
  if (auto status = opened->read_invocation(frame->session()); !status) return status.error();
  return opened;
}

bool OpenModel::takes_empty() const {
  const auto model = lease_->shared()->model();
  return model && !fallback_ && (model->info().flags & WEIR_MODEL_EMPTY_INPUT) != 0;
}

// Opens the model, and the fallback if there is one. A fallback also describes a model whose
// server does not answer yet.
Status OpenModel::open_lease(const FilterSettings& s, std::vector<Error>* warnings) {
  if (!s.fallback.empty()) {
    auto fallback = Fallback::open(s);
    if (!fallback) return fallback.error();
    fallback_ = *std::move(fallback);
  }
  std::optional<Error> warning;
  auto source = make_model_config(s, monitor_, &warning);
  if (!source) return source.error();
  add(warning, warnings);
  Status status = open_lease(*source, s, warnings);
  if (status || !fallback_ || status.error().code != Code::SERVER_UNREACHABLE) return status;
  source = make_model_config(fallback_->declare_tensors(s), monitor_, nullptr);
  return source ? open_lease(*source, s, warnings) : Status(source.error());
}

Status OpenModel::open_lease(const infer::ModelConfig& source, const FilterSettings& s,
                             std::vector<Error>* warnings) {
  const auto found = infer::ModelTable::instance().find(shared_key(s, warnings), source);
  add(found.not_shared, warnings);
  auto use = infer::ModelLease::create(found.model, count_sessions(s, warnings));
  if (!use) return use.error();
  workers_ = s.workers;
  const auto model = found.model->model();
  if (const auto parallel = model ? parallel_invokes(model->info(), s) : 1; parallel > 1) {
    use = infer::ModelLease::create(found.model, workers_ = parallel);
    if (!use) return use.error();
  }
  lease_ = *std::move(use);
  return ok();
}

// The spec of one frame and, for batches, the batch group.
Result<ModelTensors> OpenModel::read_tensors(const infer::Model& model, const FilterSettings& s) {
  const auto &inputs = model.inputs(), &outputs = model.outputs();
  batch_size_ = s.batch_size;
  if (batch_size_ == 1) {
    ModelTensors tensors{model_tensors(inputs), model_tensors(outputs)};
    if (!rows_.single) return tensors;
    for (auto* shapes : {&tensors.inputs, &tensors.outputs}) set_rows(shapes, -1);
    return tensors;
  }
  if (s.invoke_async)
    return Error{
        .code = Code::BATCH_UNSUPPORTED,
        .what = "frames cannot be batched for an engine that answers asynchronously",
        .offered = "batch-size=" + std::to_string(s.batch_size) + " with invoke-async=true",
        .needed = "one of them",
        .fix = "tensor_filter invoke-async=true batch-size=1"};
  if (s.workers > 1)
    return Error{
        .code = Code::OPTION_VALUE,
        .what = "batches run one at a time, in one session",
        .offered = "workers=" + std::to_string(s.workers) +
                   " with batch-size=" + std::to_string(batch_size_),
        .needed = "workers=1, and more threads of the engine for each batch; or batch-size=1",
        .fix = "tensor_filter batch-size=" + std::to_string(batch_size_) + " workers=1 threads=" +
               std::to_string(static_cast<int>(s.workers) * std::max(s.threads, 1))};
  auto axes = infer::find_batch_axes(model.info().flags, inputs, outputs, batch_size_);
  if (!axes) return axes.error();
  batch_axes_ = *std::move(axes);
  return ModelTensors{
      model_tensors(infer::of_one_frame(inputs, batch_axes_.inputs, batch_size_)),
      model_tensors(infer::of_one_frame(outputs, batch_axes_.outputs, batch_size_))};
}

Status OpenModel::plan_batch(const FrameSpec& input, FilterPlan* plan) const {
  const auto open = std::find_if(plan->model_inputs.begin(), plan->model_inputs.end(),
                                 [](const auto& shape) { return !shape.fixed(); });
  if (input.format != Format::Static && open != plan->model_inputs.end())
    return Error{
        .code = Code::BATCH_UNSUPPORTED,
        .what = "frames whose shapes may change from one to the next cannot be batched",
        .offered = input.to_string() + ", for a model of " + list_tensors(plan->model_inputs),
        .needed = "a static stream, or one shape for all frames",
        .fix =
            "tensor_filter input=... inputtype=..., tensor_converter ! tensor_filter, or set "
            "batch-size=1"};
  auto batch =
      infer::join_model_batch(lease_->shared(), batch_axes_, batch_size_, plan->model_inputs);
  if (!batch) return batch.error();
  auto agreed = with_user_settings(std::move(batch->outputs), description_.declared.output,
                                   description_.declared.outputtype, "output");
  if (!agreed) return agreed.error();
  plan->batch = std::move(batch->group);
  plan->model_outputs = *std::move(agreed);
  for (size_t i = 0; i < plan->model_outputs.size(); ++i)
    plan->model_outputs[i].name = outputs()[i].name;
  return ok();
}

Status OpenModel::read_invocation(const infer::Session& session) const {
  if (!session.is_asynchronous())
    return Error{.code = Code::MODEL_UNSUPPORTED,
                 .what = "the engine supports only synchronous invokes of this model",
                 .offered = "invoke-async=true with framework=" + engine_,
                 .needed = "an engine with submit(), and a model for which it can be used",
                 .fix = "tensor_filter invoke-async=false"};
  if (!description_.output_choice.inputs.empty())
    return Error{
        .code = Code::OPTION_VALUE,
        .what = "output-combination cannot contain inputs when the engine answers asynchronously",
        .offered = "i" + std::to_string(description_.output_choice.inputs[0]),
        .needed = "outputs only: a frame may have any number of them",
        .fix = "tensor_filter invoke-async=true output-combination=o0"};
  return ok();
}

gst::Allocation OpenModel::allocation() const noexcept {
  gst::Allocation out;
  out.allocator = shared_memory_;
  const auto model = lease_->shared()->model();  // null while the model is suspended
  if (!model) return out;
  out.alignment = std::max<size_t>(out.alignment, model->info().alignment);
  out.padding = model->info().input_padding;
  if (!fallback_) return out;
  out.alignment = std::max<size_t>(out.alignment, fallback_->info().alignment);
  out.padding = std::max<size_t>(out.padding, fallback_->info().input_padding);
  return out;
}

// The outputs that `session` resolves for these inputs; of a model of one row, those of all rows.
Result<std::vector<ModelTensor>> OpenModel::resolve(
    const std::vector<ModelTensor>& inputs,
    const std::function<Result<std::vector<ModelTensor>>(const std::vector<ModelTensor>&)>& session)
    const {
  if (!rows_.single) return session(inputs);
  auto one = inputs;
  set_rows(&one, 1);
  auto outputs = session(one);
  if (outputs) set_rows(&*outputs, inputs[0].shape.at(0));
  return outputs;
}

Result<FilterPlan> OpenModel::plan_for_shapes(FilterPlan plan,
                                              const infer::ModelLease::Frame& frame, size_t session,
                                              std::vector<ModelTensor> inputs) const {
  auto resolved =
      resolve(inputs, [&](const auto& shapes) { return lease_->resolve(frame, session, shapes); });
  if (!resolved) return resolved.error();
  auto outputs = description_.complete_outputs(*std::move(resolved));
  if (!outputs) return outputs.error();
  plan.model_inputs = std::move(inputs);
  plan.model_outputs = *std::move(outputs);
  plan.outputs_fixed = all_fixed(plan.model_outputs);
  return plan;
}

Result<DescribedModel> OpenModel::described(const FilterPlan& plan) const {
  auto model = lease_->shared()->model();
  if (!model) {
    const auto frame = lease_->begin();
    if (!frame) return frame.error();
    model = lease_->shared()->model();
  }
  DescribedModel out;
  if (!model) return out;
  out.inputs = described_tensors(plan.model_inputs, model->inputs());
  out.outputs = described_tensors(plan.model_outputs, model->outputs());
  if (!plan.output_choice.empty()) out.outputs = pushed_tensors(plan, out.outputs);
  const auto paths = lease_->shared()->source().options.paths;
  if (!paths.empty()) out.path = paths[0];
  if (const char* metadata = model->info().metadata_json) out.metadata_json = metadata;
  return out;
}

Status OpenModel::replace(const FilterSettings& settings) const {
  const auto source = make_model_config(settings, monitor_, nullptr);
  if (!source) return source.error();
  return lease_->shared()->replace(*source);
}

void OpenModel::add_stats(GstStructure* stats) const {
  if (fallback_) fallback_->add_stats(stats);
  const auto& shared = *lease_->shared();
  const auto model = shared.model();
  const std::string accelerator = model && isolate::get_arena(*model)
                                      ? isolate::accelerator_in(*model).used
                                      : shared.source().options.accelerator;
  gst_structure_set(stats, "weights-bytes", G_TYPE_UINT64,
                    model ? guint64{model->info().weight_bytes} : guint64{0}, "shared-by",
                    G_TYPE_UINT64, guint64{shared.users()}, "reloads", G_TYPE_UINT64,
                    guint64{shared.reloads()}, "suspended", G_TYPE_BOOLEAN,
                    gboolean{lease_->suspended()}, "accelerator", G_TYPE_STRING,
                    accelerator.c_str(), nullptr);
  if (model) add_engine_stats(*model, stats);
  const auto execution = model ? model->execution() : std::nullopt;
  if (!execution) return;
  gst_structure_set(stats, "threads", G_TYPE_INT, static_cast<int>(execution->threads), "spinning",
                    G_TYPE_BOOLEAN, gboolean{execution->spins != 0}, nullptr);
}

Status OpenModel::fit_inputs(const std::vector<TensorSpec>& stream, FilterPlan* plan) const {
  auto chosen = choose_tensors(stream, plan->input_choice, "input-combination");
  if (!chosen) return chosen.error();
  auto fitted = fit(inputs(), *chosen);
  if (!fitted) return fitted.error();
  plan->model_inputs = *std::move(fitted);
  return ok();
}

Status OpenModel::resolve_outputs(FilterPlan* plan) const {
  auto resolved =
      resolve(plan->model_inputs, [this](const auto& shapes) { return lease_->resolve(shapes); });
  if (!resolved) return resolved.error();
  auto complete = description_.complete_outputs(*std::move(resolved));
  if (!complete) return complete.error();
  plan->model_outputs = *std::move(complete);
  return ok();
}

namespace {

// What the fallback, which may be null, needs of the input memory; prepares it for fixed shapes.
Status plan_fallback(Fallback* fallback, FilterPlan* plan) {
  if (!fallback) return ok();
  const auto info = fallback->info();
  plan->fallback_alignment = std::max<size_t>(info.alignment, 1);
  plan->fallback_padding = info.input_padding;
  if (!all_fixed(plan->model_inputs)) return ok();
  return fallback->prepare(plan->model_inputs, plan->model_outputs);
}

}  // namespace

Result<FilterPlan> OpenModel::plan_for(const FrameSpec& input) const {
  FilterPlan plan;
  if (const auto model = lease_->shared()->model()) {  // each frame uses the model that runs it
    plan.alignment = model->info().alignment;
    plan.padding = model->info().input_padding;
  }
  plan.input = input;
  plan.input_choice = description_.input_choice;
  plan.output_choice = description_.output_choice;
  plan.dynamic = is_dynamic();
  plan.rows = rows_;
  plan.engine_allocates = asynchronous_ || allocates_ || (is_dynamic() && decides_sizes_);
  plan.declared_inputs = plan.model_inputs = inputs();
  plan.model_outputs = outputs();
  if (input.format == Format::Static)
    if (auto status = fit_inputs(input.tensors, &plan); !status) return status.error();
  if (batch_size_ > 1) {
    if (auto status = plan_batch(input, &plan); !status) return status.error();
  } else if (all_fixed(plan.model_inputs)) {
    if (auto status = resolve_outputs(&plan); !status) return status.error();
  }
  plan.outputs_fixed = all_fixed(plan.model_outputs) && all_fixed(plan.model_inputs);
  if (auto status = plan_fallback(fallback_.get(), &plan); !status) return status.error();
  auto output = description_.source_spec(input, plan.model_outputs, plan.outputs_fixed);
  if (!output) return output.error();
  plan.output = *std::move(output);
  return plan;
}

}  // namespace weir
