// Transforms buffers: pooled for static streams, otherwise one memory at a time.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_transform/frame_transformer.hpp"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <utility>

#include "core/transform/transformed_source_map.hpp"
#include "gstcpp/buffer/frame_builder.hpp"
#include "gstcpp/buffer/frame_errors.hpp"
#include "gstcpp/buffer/memory_part.hpp"
#include "gstcpp/buffer/tensor_meta.hpp"

namespace weir {
namespace {

void write_header(const TensorSpec& spec, std::span<std::byte> out) {
  TensorHeader header;
  header.spec = spec;
  write_tensor_header(header, out.first<kTensorHeaderBytes>());
}

}  // namespace

bool chosen(const TensorChoice& choice, size_t index) noexcept {
  return choice.empty() || std::find(choice.begin(), choice.end(), index) != choice.end();
}

Result<std::vector<TensorSpec>> transformed(const transform::Operation& operation,
                                            const TensorChoice& choice,
                                            const std::vector<TensorSpec>& tensors) {
  std::vector<TensorSpec> out = tensors;
  for (size_t i = 0; i < tensors.size(); ++i) {
    if (!chosen(choice, i) || !tensors[i].valid()) continue;
    auto spec = transform::output_spec(operation, tensors[i]);
    if (!spec) return spec.error();
    out[i] = *std::move(spec);
  }
  return out;
}

Result<FrameTransformer::Cached*> FrameTransformer::plan_for(size_t index, const TensorSpec& spec) {
  if (plans_.size() <= index) plans_.resize(index + 1);
  auto& cached = plans_[index];
  if (cached && cached->input.type == spec.type &&
      cached->input.shape.dims() == spec.shape.dims() &&
      cached->input.shape.rank() == spec.shape.rank())
    return &*cached;
  auto out = transform::output_spec(operation_, spec);
  if (!out) return out.error();
  auto plan = transform::plan(operation_, spec, accelerate_);
  if (!plan) return plan.error();
  cached.emplace(Cached{spec, *std::move(out),
                        std::make_shared<const transform::TransformPlan>(*std::move(plan)), nullptr,
                        nullptr});
  return &*cached;
}

Status FrameTransformer::check_choice(size_t tensors, const char* of) const {
  for (const size_t index : choice_)
    if (index >= tensors)
      return Error{.code = Code::OPTION_VALUE,
                   .what = std::string("apply names a tensor that ") + of + " does not have",
                   .offered = "apply=" + std::to_string(index),
                   .needed = "0 to " + std::to_string(tensors - 1)};
  return ok();
}

void FrameTransformer::apply(const transform::TransformPlan& plan, std::span<const std::byte> in,
                             std::span<std::byte> out, Ledger* ledger) {
  const auto counters = plan.apply(in, out);
  if (counters.divisions_by_zero > 0) ledger->divided_by_zero(counters.divisions_by_zero);
}

Status FrameTransformer::configure(const FrameSpec& input, const FrameSpec& output) {
  input_ = input;
  output_ = output;
  plans_.clear();
  pooled_ = in_place_ = element_wise_ = defer_ = false;
  pool_ = view_pool_ = {};
  view_specs_.clear();
  if (input.format != Format::Static) return ok();
  if (auto status = check_choice(input.tensors.size(), "the stream"); !status) return status;
  std::vector<TensorSpec> outputs;
  bool in_place = true, element_wise = true, all = true;
  for (size_t i = 0; i < input.tensors.size(); ++i) {
    if (!chosen(choice_, i)) {
      all = false;
      continue;
    }
    auto cached = plan_for(i, input.tensors[i]);
    if (!cached) return cached.error();
    outputs.push_back((*cached)->output);
    in_place = in_place && (*cached)->plan->in_place_possible();
    element_wise = element_wise && (*cached)->plan->is_element_wise();
  }
  pooled_ = all && output.format == Format::Static;
  const bool memory_each = pooled_ && input.tensors.size() <= kMemoryLimit;
  in_place_ = memory_each && in_place;
  element_wise_ = memory_each && element_wise;
  if (!pooled_) return ok();
  return make_pool(std::move(outputs));
}

Status FrameTransformer::make_pool(std::vector<TensorSpec> outputs) {
  auto pool =
      gst::FramePool::make(std::move(outputs), Format::Static, MediaType::Tensor, allocation_);
  if (!pool) return pool.error();
  pool_ = *std::move(pool);
  return ok();
}

Status FrameTransformer::allocate_as(const gst::Allocation& allocation) {
  if (allocation == allocation_) return ok();
  allocation_ = allocation;
  view_pool_ = {};
  return pooled_ ? make_pool(pool_.tensors()) : ok();
}

Result<gst::Ref<GstBuffer>> FrameTransformer::output_for(GstBuffer* in) {
  work_ = {};
  const bool flexible = input_.format == Format::Flexible;
  if (flexible)
    find_views(in);
  else
    find_fused_sources(in);
  work_.fused = !sources_.empty();
  work_.deferred = !flexible && may_defer(in);
  if (work_.deferred) return deferred_output(in);
  if (work_.fused && flexible) return buffer_for_views();
  if (work_.fused) {
    if (auto source = take_source(in)) return source;
  } else if (in_place_ && gst::can_be_written(in) &&
             gst_buffer_n_memory(in) == input_.tensors.size()) {
    return gst::Ref<GstBuffer>::share(in);
  }
  if (pooled_) return pool_.acquire(limit_);
  return gst::Ref<GstBuffer>::adopt(gst_buffer_new());
}

void FrameTransformer::move_pictures(GstBuffer* out) const {
  const auto mode = operation_.mode();
  if (mode != transform::Mode::Transpose && mode != transform::Mode::Dimchg &&
      mode != transform::Mode::Padding)
    return;
  const auto maps = gst::source_maps(out);
  if (maps.empty()) return;
  std::vector<SourceMap> moved(maps.begin(), maps.end());
  const auto of = gst::maps_of(out);
  const bool regions = of == gst::MapsOf::Regions;
  // One map applies to all tensors: if only some are transformed, each needs its own.
  if (!regions && moved.size() == 1 && !choice_.empty() && tensors_ > 1)
    moved.resize(tensors_, moved[0]);
  // If only some tensors of regions are transformed, their maps differ: the first tensor's is kept.
  for (size_t i = 0; i < moved.size(); ++i)
    if (chosen(choice_, regions ? 0 : i))
      moved[i] = transform::transform_source_map(operation_, moved[i]);
  gst::set_source_maps(out, std::move(moved), of);
}

Result<FrameTransformer::Work> FrameTransformer::run(GstBuffer* in, GstBuffer* out,
                                                     Ledger* ledger) {
  Status status = ok();
  tensors_ = input_.tensors.size();
  if (work_.fused && input_.format == Format::Flexible)
    status = run_views(out, ledger);
  else if (!work_.deferred)
    status = work_.fused ? run_fused(out, ledger) : run_alone(in, out, ledger);
  writer_.unmap();
  reader_.clear();
  sources_.clear();
  if (!status) return std::move(status).error();
  move_pictures(out);
  return work_;
}

Status FrameTransformer::run_alone(GstBuffer* in, GstBuffer* out, Ledger* ledger) {
  Status status = reader_.read(in, input_, in == out ? GST_MAP_READWRITE : GST_MAP_READ);
  tensors_ = reader_.tensors().size();
  if (status) status = pooled_ ? run_pooled(in, out, ledger) : run_by_memory(in, out, ledger);
  ledger->copied(reader_.bytes_copied());
  return status;
}

Status FrameTransformer::run_pooled(GstBuffer* in, GstBuffer* out, Ledger* ledger) {
  if (in != out)
    if (auto status = writer_.map(pool_, out); !status) return status;
  const auto& views = reader_.tensors();
  for (size_t i = 0; i < views.size(); ++i) {
    auto cached = plan_for(i, views[i].spec);
    if (!cached) return cached.error();
    const auto target = in == out ? views[i].payload : writer_.payloads()[i];
    apply(*(*cached)->plan, views[i].payload, target, ledger);
  }
  return ok();
}

Status FrameTransformer::run_by_memory(GstBuffer* in, GstBuffer* out, Ledger* ledger) {
  const auto& views = reader_.tensors();
  if (auto status = check_choice(views.size(), "this frame"); !status) return status;
  if (views.size() > kMemoryLimit) return run_packed(out, ledger);
  for (size_t i = 0; i < views.size(); ++i) {
    Status status = chosen(choice_, i) ? append_transformed(i, views[i], out, ledger)
                                       : append_untouched(views[i], in, out, ledger);
    if (!status) return status;
  }
  return ok();
}

// More tensors than a buffer has memories: none are shared.
Status FrameTransformer::run_packed(GstBuffer* out, Ledger* ledger) {
  const auto& views = reader_.tensors();
  const size_t head = headers_wanted() ? kTensorHeaderBytes : 0;
  std::vector<TensorSpec> specs;
  std::vector<uint64_t> sizes;
  for (size_t i = 0; i < views.size(); ++i) {
    specs.push_back(views[i].spec);
    if (chosen(choice_, i)) {
      const auto cached = plan_for(i, views[i].spec);
      if (!cached) return cached.error();
      specs.back() = (*cached)->output;
    }
    sizes.push_back(head + *specs.back().bytes());
  }
  const auto total = std::accumulate(sizes.begin(), sizes.end(), uint64_t{0});
  if (auto status = limit_.check(total); !status) return status;
  return gst::append_filled(specs, sizes, out, [&](size_t i, std::span<std::byte> bytes) -> Status {
    if (head) write_header(specs[i], bytes);
    const auto target = bytes.subspan(head);
    if (chosen(choice_, i)) {
      apply(*plans_[i]->plan, views[i].payload, target, ledger);
    } else {
      std::copy(views[i].payload.begin(), views[i].payload.end(), target.begin());
      ledger->copied(target.size());
    }
    return ok();
  });
}

Status FrameTransformer::append_transformed(size_t index, const gst::TensorPlace& view,
                                            GstBuffer* out, Ledger* ledger) {
  auto cached = plan_for(index, view.spec);
  if (!cached) return cached.error();
  const TensorSpec& spec = (*cached)->output;
  const auto target = append_output(spec, *spec.bytes(), out);
  if (!target) return target.error();
  apply(*(*cached)->plan, view.payload, target->payload(), ledger);
  return ok();
}

Result<FrameTransformer::Appended> FrameTransformer::append_output(const TensorSpec& spec,
                                                                   size_t bytes,
                                                                   GstBuffer* out) const {
  const size_t head = headers_wanted() ? kTensorHeaderBytes : 0;
  if (auto status = limit_.check(gst_buffer_get_size(out) + head + bytes); !status)
    return status.error();
  auto memory = gst::allocate_memory(head + bytes);
  if (!memory) return memory.error();
  Appended appended{gst::MappedMemory(memory->get(), GST_MAP_WRITE), head};
  if (!appended.map) return gst::memory_ran_out(head + bytes);
  gst_buffer_append_memory(out, memory->release());
  if (head) write_header(spec, appended.map.bytes());
  return appended;
}

Status FrameTransformer::append_untouched(const gst::TensorPlace& view, GstBuffer* in,
                                          GstBuffer* out, Ledger* ledger) const {
  const bool had_header = view.header_bytes > 0;
  if (view.memory >= 0 && had_header == headers_wanted()) {
    gst_buffer_append_memory(
        out, gst_memory_ref(gst_buffer_peek_memory(in, static_cast<guint>(view.memory))));
    return ok();
  }
  const auto target = append_output(view.spec, view.payload.size(), out);
  if (!target) return target.error();
  std::memcpy(target->payload().data(), view.payload.data(), view.payload.size());
  ledger->copied(view.payload.size());
  return ok();
}

}  // namespace weir
