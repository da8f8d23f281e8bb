// Opening a model from the element's settings, and planning for caps.
#include "elements/tensor_filter/opened_model.hpp"

#include <algorithm>

#include "core/custom/custom_easy.hpp"
#include "core/filter/layout.hpp"
#include "core/isolate/isolated_engine.hpp"
#include "elements/tensor_filter/model_info.hpp"
#include "elements/tensor_filter/model_source.hpp"
#include "gstcpp/shared_allocator.hpp"

namespace weir {
namespace {

void set_names(const std::string& names, std::vector<ModelShape>* shapes) {
  const auto list = parse_name_list(names);
  for (size_t i = 0; i < std::min(list.size(), shapes->size()); ++i)
    if (!list[i].empty()) (*shapes)[i].name = list[i];
}

// A worker process is of one filter only.
std::string shared_key(const FilterSettings& s, std::vector<Error>* warnings) {
  if (s.isolate == IsolateChoice::None) return s.shared_tensor_filter_key.value_or("");
  if (s.shared_tensor_filter_key)
    warnings->push_back({Code::OPTION_VALUE, "a model in a process of its own is not shared",
                         "isolate=process shared-tensor-filter-key=" + *s.shared_tensor_filter_key,
                         "isolate=none, to share it", "", ""});
  return "";
}

// False for none: a model that leaves the number of its tensors open.
bool all_fixed(const std::vector<ModelShape>& shapes) {
  return !shapes.empty() &&
         std::all_of(shapes.begin(), shapes.end(), [](const auto& shape) { return shape.fixed(); });
}

// Settings under which a frame's batch cannot be run in parts.
Status check_parts(const FilterSettings& s) {
  const auto other = [&](const std::string& what) {
    return Error{Code::OPTION_VALUE,
                 "frames are not run in parts in this way",
                 what + " with invoke-rows=" + std::to_string(s.invoke_rows) +
                     " invoke-threads=" + std::to_string(s.invoke_threads),
                 "one of them",
                 "",
                 "tensor_filter invoke-rows=0 invoke-threads=1"};
  };
  if (s.batch_size > 1) return other("batch-size=" + std::to_string(s.batch_size));
  if (s.invoke_async) return other("invoke-async=true");
  if (s.isolate != IsolateChoice::None) return other("isolate=process");
  return ok();
}

// Batches have a session of their own, for all that share the model.
size_t sessions_of(const FilterSettings& s, std::vector<Error>* warnings) {
  if (s.batch_size > 1) return 0;
  if (!s.invoke_async) return size_t{s.workers} * s.invoke_threads;
  if (s.workers > 1)
    warnings->push_back({Code::OPTION_VALUE,
                         "workers do nothing where the engine has its own threads",
                         "workers=" + std::to_string(s.workers) + " with invoke-async=true",
                         "workers=1: the model says how many frames may be in work", "",
                         "tensor_filter invoke-async=true workers=1"});
  return 1;
}

}  // namespace

Result<std::unique_ptr<OpenedModel>> OpenedModel::open(const FilterSettings& s,
                                                       std::shared_ptr<isolate::Monitor> monitor,
                                                       std::vector<Error>* warnings) {
  const auto warn = [warnings](const std::optional<Error>& warning) {
    if (warning) warnings->push_back(*warning);
  };
  const infer::RowLimits rows{s.invoke_rows, s.invoke_threads};
  if (!rows.none())
    if (auto status = check_parts(s); !status) return status.error();
  std::optional<Error> warning;
  const auto source = model_source(s, monitor, &warning);
  if (!source) return source.error();
  warn(warning);
  auto opened = std::make_unique<OpenedModel>();
  opened->monitor_ = std::move(monitor);
  auto found = infer::ModelTable::instance().find(shared_key(s, warnings), *source);
  warn(found.not_shared);
  auto use = infer::ModelUse::create(std::move(found.model), sessions_of(s, warnings));
  if (!use) return use.error();
  opened->use_ = *std::move(use);
  const auto frame = opened->begin();
  if (!frame) return frame.error();
  const infer::Model& model = frame->model();
  opened->engine_ = source->engine->name;
  if (auto arena = isolate::arena_of(model)) {
    opened->engine_ = isolate::engine_in(model);
    opened->shared_memory_ = gst::shared_allocator(std::move(arena));
  }
  if (auto status =
          custom::check_invocation(model.engine(), model.info(), s.model, s.invoke_dynamic);
      !status)
    return status.error();
  if (auto status = opened->read_tensors(model, s); !status) return status.error();
  if (!rows.none())
    if (auto status = infer::check_rows(model.info().flags, model.inputs(), model.outputs());
        !status)
      return status.error();
  opened->rows_ = rows;
  auto inputs = with_user_settings(std::move(opened->inputs_), s.input, s.inputtype, "input");
  if (!inputs) return inputs.error();
  auto outputs = with_user_settings(std::move(opened->outputs_), s.output, s.outputtype, "output");
  if (!outputs) return outputs.error();
  opened->inputs_ = *std::move(inputs);
  opened->outputs_ = *std::move(outputs);
  opened->output_ = s.output;
  opened->outputtype_ = s.outputtype;
  set_names(s.inputname, &opened->inputs_);
  set_names(s.outputname, &opened->outputs_);
  for (const bool input : {true, false}) {
    warning.reset();
    set_layouts(parse_layout_list(input ? s.inputlayout : s.outputlayout,
                                  input ? "inputlayout" : "outputlayout", &warning),
                input ? &opened->inputs_ : &opened->outputs_);
    warn(warning);
  }
  if (auto status = opened->read_combinations(s); !status) return status.error();
  opened->dynamic_ = s.invoke_dynamic;
  opened->asynchronous_ = s.invoke_async;
  opened->decides_sizes_ = (model.info().flags & WEIR_MODEL_DYNAMIC_OUTPUT) != 0;
  // A worker process gives none away, and batches have memory for several frames.
  opened->allocates_ = (model.info().flags & WEIR_MODEL_ALLOCATES_OUTPUT) != 0 &&
                       !opened->monitor_ && s.batch_size == 1 &&
                       opened->outputs_.size() <= kMemoryLimit;
  if (!s.invoke_async) return opened;
  if (auto status = opened->read_invocation(frame->session()); !status) return status.error();
  return opened;
}

// Says what one frame is, and what batches need.
Status OpenedModel::read_tensors(const infer::Model& model, const FilterSettings& s) {
  const auto &inputs = model.inputs(), &outputs = model.outputs();
  batch_size_ = s.batch_size;
  if (batch_size_ == 1) {
    inputs_ = model_shapes(inputs);
    outputs_ = model_shapes(outputs);
    return ok();
  }
  if (s.invoke_async)
    return Error{Code::BATCH_UNSUPPORTED,
                 "frames cannot be gathered for an engine that answers asynchronously",
                 "batch-size=" + std::to_string(s.batch_size) + " with invoke-async=true",
                 "one of them",
                 "",
                 "tensor_filter invoke-async=true batch-size=1"};
  if (s.workers > 1)
    return Error{
        Code::OPTION_VALUE,
        "frames that are gathered are run one batch at a time, in one session",
        "workers=" + std::to_string(s.workers) + " with batch-size=" + std::to_string(batch_size_),
        "workers=1, and more threads of the engine for each batch; or batch-size=1",
        "",
        "tensor_filter batch-size=" + std::to_string(batch_size_) + " workers=1 threads=" +
            std::to_string(static_cast<int>(s.workers) * std::max(s.threads, 1))};
  auto axes = infer::find_batch_axes(model.info().flags, inputs, outputs, batch_size_);
  if (!axes) return axes.error();
  inputs_ = model_shapes(infer::of_one_frame(inputs, axes->inputs, batch_size_));
  outputs_ = model_shapes(infer::of_one_frame(outputs, axes->outputs, batch_size_));
  batch_axes_ = *std::move(axes);
  return ok();
}

Status OpenedModel::plan_batch(const FrameSpec& input, FilterPlan* plan) const {
  const auto open = std::find_if(plan->model_inputs.begin(), plan->model_inputs.end(),
                                 [](const auto& shape) { return !shape.fixed(); });
  if (input.format != Format::Static && open != plan->model_inputs.end())
    return Error{Code::BATCH_UNSUPPORTED,
                 "frames whose shapes may change from one to the next cannot be gathered",
                 input.to_string() + ", for a model of " + list_shapes(plan->model_inputs),
                 "a static stream, or one shape for all frames",
                 "",
                 "tensor_filter input=... inputtype=..., tensor_converter ! tensor_filter, or set "
                 "batch-size=1"};
  auto batch =
      infer::join_model_batch(use_->shared(), batch_axes_, batch_size_, plan->model_inputs);
  if (!batch) return batch.error();
  auto outputs = with_user_settings(std::move(batch->outputs), output_, outputtype_, "output");
  if (!outputs) return outputs.error();
  plan->batch = std::move(batch->group);
  plan->model_outputs = *std::move(outputs);
  for (size_t i = 0; i < plan->model_outputs.size(); ++i)
    plan->model_outputs[i].name = outputs_[i].name;
  return ok();
}

Status OpenedModel::read_combinations(const FilterSettings& s) {
  auto input = parse_input_combination(s.input_combination);
  if (!input) return input.error();
  auto output = parse_output_combination(s.output_combination);
  if (!output) return output.error();
  input_choice_ = *std::move(input);
  output_choice_ = *std::move(output);
  return outputs_.empty() ? ok() : check_choice(outputs_);
}

Status OpenedModel::check_choice(const std::vector<ModelShape>& outputs) const {
  for (const size_t index : output_choice_.outputs)
    if (index >= outputs.size())
      return Error{Code::OPTION_VALUE,
                   "output-combination names an output that the model lacks",
                   "o" + std::to_string(index),
                   std::to_string(outputs.size()) + " outputs, from o0 on",
                   "",
                   "output-combination=o0"};
  return ok();
}

Result<std::vector<ModelShape>> OpenedModel::complete(std::vector<ModelShape> resolved) const {
  if (resolved.size() != outputs_.size() && !resolved.empty() && !outputs_.empty())
    return Error{Code::SPEC_MISMATCH,
                 "output= has another number of tensors than the model gives for this stream",
                 list_shapes(outputs_),
                 list_shapes(resolved),
                 "number of tensors",
                 "leave output and outputtype away: the model says it"};
  if (!resolved.empty()) {
    auto agreed = with_user_settings(std::move(resolved), output_, outputtype_, "output");
    if (!agreed) return agreed.error();
    resolved = *std::move(agreed);
  }
  auto outputs = completed(std::move(resolved), outputs_);
  if (outputs.empty())
    return Error{Code::MODEL_UNSUPPORTED,
                 "the model says no outputs for this stream",
                 "",
                 "at least one",
                 "",
                 "tensor_filter output=... outputtype=..."};
  if (auto status = check_choice(outputs); !status) return status.error();
  return outputs;
}

Status OpenedModel::read_invocation(const infer::Session& session) const {
  if (!infer::answers_asynchronously(session))
    return Error{Code::MODEL_UNSUPPORTED,
                 "the engine answers this model only frame by frame",
                 "invoke-async=true with framework=" + engine_,
                 "an engine with submit(), and a model that it may be used with",
                 "",
                 "tensor_filter invoke-async=false"};
  if (!output_choice_.inputs.empty())
    return Error{Code::OPTION_VALUE,
                 "output-combination cannot have inputs when the engine answers asynchronously",
                 "i" + std::to_string(output_choice_.inputs[0]),
                 "outputs only, for a frame may have any number of them",
                 "",
                 "tensor_filter invoke-async=true output-combination=o0"};
  return ok();
}

std::vector<TensorSpec> OpenedModel::known_outputs() const {
  if (!output_choice_.inputs.empty()) return {};
  const auto all = known_parts(outputs_);
  if (output_choice_.empty()) return all;
  std::vector<TensorSpec> chosen;
  for (const size_t index : output_choice_.outputs) chosen.push_back(all[index]);
  return chosen;
}

gst::Allocation OpenedModel::allocation() const noexcept {
  gst::Allocation out;
  out.allocator = shared_memory_;
  const auto model = use_->shared()->model();  // null while it is suspended
  if (!model) return out;
  out.alignment = std::max<size_t>(out.alignment, model->info().alignment);
  out.padding = model->info().input_padding;
  return out;
}

Result<std::vector<ModelShape>> OpenedModel::resolve(const infer::ModelUse::Frame& frame,
                                                     size_t worker,
                                                     const std::vector<ModelShape>& inputs) const {
  auto outputs = use_->resolve(frame, worker, inputs);
  if (!outputs) return outputs.error();
  return complete(*std::move(outputs));
}

Status OpenedModel::replace(const FilterSettings& settings) const {
  const auto source = model_source(settings, monitor_, nullptr);
  if (!source) return source.error();
  return use_->shared()->replace(*source);
}

void OpenedModel::add_stats(GstStructure* stats) const {
  const auto& shared = *use_->shared();
  const auto model = shared.model();
  gst_structure_set(stats, "weights-bytes", G_TYPE_UINT64,
                    model ? guint64{model->info().weight_bytes} : guint64{0}, "shared-by",
                    G_TYPE_UINT64, guint64{shared.users()}, "reloads", G_TYPE_UINT64,
                    guint64{shared.reloads()}, "suspended", G_TYPE_BOOLEAN,
                    gboolean{use_->suspended()}, "accelerator", G_TYPE_STRING,
                    shared.source().options.accelerator.c_str(), nullptr);
  const auto execution = model ? model->execution() : std::nullopt;
  if (!execution) return;
  gst_structure_set(stats, "threads", G_TYPE_INT, static_cast<int>(execution->threads), "spinning",
                    G_TYPE_BOOLEAN, gboolean{execution->spins != 0}, nullptr);
}

Result<FilterPlan> OpenedModel::plan_for(const FrameSpec& input) const {
  FilterPlan plan;
  if (const auto model = use_->shared()->model()) {  // frames ask the model that runs them
    plan.alignment = model->info().alignment;
    plan.padding = model->info().input_padding;
  }
  plan.input = input;
  plan.input_choice = input_choice_;
  plan.output_choice = output_choice_;
  plan.dynamic = dynamic_;
  plan.rows = rows_;
  plan.engine_allocates = asynchronous_ || allocates_ || (dynamic_ && decides_sizes_);
  plan.declared_inputs = inputs_;
  plan.model_inputs = inputs_;
  plan.model_outputs = outputs_;
  if (input.format == Format::Static) {
    auto chosen = choose_tensors(input.tensors, input_choice_, "input-combination");
    if (!chosen) return chosen.error();
    auto fitted = fit(inputs_, *chosen);
    if (!fitted) return fitted.error();
    plan.model_inputs = *std::move(fitted);
  }
  if (batch_size_ == 1 && all_fixed(plan.model_inputs)) {
    auto outputs = use_->resolve(plan.model_inputs);
    if (!outputs) return outputs.error();
    auto complete_ones = complete(*std::move(outputs));
    if (!complete_ones) return complete_ones.error();
    plan.model_outputs = *std::move(complete_ones);
  }
  if (batch_size_ > 1)
    if (auto status = plan_batch(input, &plan); !status) return status.error();
  plan.outputs_fixed = all_fixed(plan.model_outputs) && all_fixed(plan.model_inputs);
  plan.output.rate = input.rate;
  const bool flexible = dynamic_ || !plan.outputs_fixed;
  plan.output.format = flexible ? Format::Flexible : Format::Static;
  if (flexible) return plan;
  auto images = choose_tensors(input.tensors, output_choice_.inputs, "output-combination");
  if (!images) return images.error();
  if (!output_choice_.inputs.empty()) plan.output.tensors = *std::move(images);
  const auto all = known_parts(plan.model_outputs);
  for (size_t i = 0; i < all.size(); ++i)
    if (output_choice_.empty() ||
        std::find(output_choice_.outputs.begin(), output_choice_.outputs.end(), i) !=
            output_choice_.outputs.end())
      plan.output.tensors.push_back(all[i]);
  return plan;
}

}  // namespace weir
