// FrameTransformer: fuses two chained transforms into one pass; outputs deferred memory, and uses
// the deferred memory of the upstream element.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>

#include "elements/tensor_transform/frame_transformer.hpp"
#include "gstcpp/buffer/frame_errors.hpp"
#include "gstcpp/buffer/memory_part.hpp"

namespace weir {
namespace {

Error source_not_mapped(guint memory) {
  return Error{.code = Code::MAPPING_FAILED,
               .what = "the input memory of the upstream tensor_transform cannot be mapped",
               .offered = "memory " + std::to_string(memory),
               .needed = "system memory",
               .fix = "put a queue between the two tensor_transform"};
}

}  // namespace

void FrameTransformer::defer(bool wanted) noexcept {
  defer_ = wanted;
  computed_before_ = counts_->computed;
}

void FrameTransformer::find_fused_sources(GstBuffer* in) {
  sources_.clear();
  if (!element_wise_ || gst_buffer_n_memory(in) != input_.tensors.size()) return;
  for (size_t i = 0; i < input_.tensors.size(); ++i) {
    auto source = gst::deferred_source(gst_buffer_peek_memory(in, static_cast<guint>(i)));
    auto& cached = plans_[i];
    if (!source || !source->header.empty() || !cached ||
        !source->plan->output().same_layout(cached->input) || !fuse(*cached, &*source))
      return sources_.clear();
    sources_.push_back(*std::move(source));
  }
}

bool FrameTransformer::fuse(Cached& cached, gst::DeferredSource* source) {
  if (cached.before != source->plan) {
    auto both = transform::fused(*source->plan, *cached.plan);
    cached.before = source->plan;
    cached.both =
        both ? std::make_shared<const transform::TransformPlan>(*std::move(both)) : nullptr;
  }
  if (!cached.both) return false;
  source->plan = cached.both;
  return true;
}

bool FrameTransformer::takes_views() const noexcept {
  const auto mode = operation_.mode();
  return input_.format == Format::Flexible && choice_.empty() &&
         (mode == transform::Mode::Typecast || mode == transform::Mode::Arithmetic ||
          mode == transform::Mode::Clamp);
}

void FrameTransformer::find_views(GstBuffer* in) {
  sources_.clear();
  if (!takes_views()) return;
  for (guint i = 0; i < gst_buffer_n_memory(in); ++i) {
    auto sources = gst::deferred_sources(gst_buffer_peek_memory(in, i));
    if (sources.empty()) return sources_.clear();
    for (auto& source : sources) {
      if (source.header.empty()) return sources_.clear();
      auto cached = plan_for(sources_.size(), source.plan->output());
      if (!cached || !fuse(**cached, &source)) return sources_.clear();
      sources_.push_back(std::move(source));
    }
  }
}

// Pooled from the second frame with the same sizes on; and always for more than 16 tensors, because
// the pool handles the packed memory.
Result<gst::Ref<GstBuffer>> FrameTransformer::buffer_for_views() {
  std::vector<TensorSpec> specs;
  for (const auto& source : sources_) specs.push_back(source.plan->output());
  const auto alike = [](const TensorSpec& a, const TensorSpec& b) { return a.same_layout(b); };
  const bool as_before =
      std::equal(specs.begin(), specs.end(), view_specs_.begin(), view_specs_.end(), alike);
  if (!as_before) {
    view_specs_ = specs;
    view_pool_ = {};
  }
  views_pooled_ = as_before || specs.size() > kMemoryLimit;
  if (!views_pooled_) return gst::Ref<GstBuffer>::adopt(gst_buffer_new());
  if (!view_pool_) {
    auto pool =
        gst::FramePool::make(std::move(specs), output_.format, MediaType::Tensor, allocation_);
    if (!pool) return pool.error();
    view_pool_ = *std::move(pool);
  }
  auto out = view_pool_.acquire(limit_);
  view_buffers_ = view_pool_.stats().allocated;
  return out;
}

Status FrameTransformer::run_views(GstBuffer* out, Ledger* ledger) {
  tensors_ = sources_.size();
  if (views_pooled_)
    if (auto status = writer_.map(view_pool_, out); !status) return status;
  for (size_t i = 0; i < sources_.size(); ++i) {
    const auto& [buffer, memory, plan, header] = sources_[i];
    const gst::MappedMemory in(gst_buffer_peek_memory(buffer.get(), memory), GST_MAP_READ);
    if (!in || in.bytes().size() < plan->input().bytes()) return source_not_mapped(memory);
    Appended appended;
    if (!views_pooled_) {
      auto made = append_output(plan->output(), *plan->output().bytes(), out);
      if (!made) return made.error();
      appended = *std::move(made);
    }
    const auto target = views_pooled_ ? writer_.payloads()[i] : appended.payload();
    apply(*plan, in.bytes(), target, ledger);
  }
  return ok();
}

// True for system memory of the sizes of the caps; other memory is rejected or converted now. If
// deferred memory is being mapped, computing into pooled memory is faster.
bool FrameTransformer::may_defer(GstBuffer* in) const {
  if (!defer_ || counts_->computed != computed_before_) return false;
  if (!sources_.empty()) return true;
  if (gst_buffer_n_memory(in) != input_.tensors.size()) return false;
  for (size_t i = 0; i < input_.tensors.size(); ++i) {
    GstMemory* memory = gst_buffer_peek_memory(in, static_cast<guint>(i));
    if (gst_memory_get_sizes(memory, nullptr, nullptr) != input_.tensors[i].bytes()) return false;
    if (!gst_memory_is_type(memory, GST_ALLOCATOR_SYSMEM) && !gst::is_deferred_memory(memory))
      return false;
  }
  return true;
}

Result<gst::Ref<GstBuffer>> FrameTransformer::deferred_output(GstBuffer* in) {
  if (auto status = limit_.check(output_); !status) return status.error();
  if (sources_.empty())
    for (size_t i = 0; i < input_.tensors.size(); ++i)
      sources_.push_back({gst::Ref<GstBuffer>::share(in), static_cast<guint>(i), plans_[i]->plan});
  auto out = gst::Ref<GstBuffer>::adopt(gst_buffer_new());
  for (auto& source : sources_) {
    GstMemory* memory = gst::make_deferred_memory(std::move(source), counts_);
    if (!memory) return gst::memory_ran_out(sizeof(GstMemory));
    gst_buffer_append_memory(out.get(), memory);
  }
  sources_.clear();
  return out;
}

// Whether only `sources_` and the deferred memories of this frame, not shared with others, refer to
// the source.
bool FrameTransformer::has_source_alone(GstBuffer* in) const {
  if (!gst_buffer_is_writable(in) || !gst_buffer_is_all_memory_writable(in)) return false;
  GstBuffer* source = sources_[0].buffer.get();
  if (gst_buffer_n_memory(source) != sources_.size()) return false;
  for (size_t i = 0; i < sources_.size(); ++i) {
    const auto& [buffer, memory, plan, header] = sources_[i];
    if (buffer.get() != source || memory != i || !plan->in_place_possible()) return false;
    if (gst_memory_get_sizes(gst_buffer_peek_memory(source, memory), nullptr, nullptr) !=
        plan->output().bytes())
      return false;
  }
  if (static_cast<size_t>(GST_MINI_OBJECT_REFCOUNT_VALUE(source)) != 2 * sources_.size())
    return false;
  gpointer state = nullptr;
  while (const GstMeta* meta = gst_buffer_iterate_meta(source, &state))
    if ((meta->flags & (GST_META_FLAG_POOLED | GST_META_FLAG_LOCKED)) != 0) return false;
  return true;
}

// Without its metadata: that of `in` is newer, since a probe may have changed it.
gst::Ref<GstBuffer> FrameTransformer::take_source(GstBuffer* in) {
  if (!has_source_alone(in)) return {};
  auto out = gst::Ref<GstBuffer>::share(sources_[0].buffer.get());
  for (size_t i = 0; i < sources_.size(); ++i) {
    gst::forget_deferred_source(gst_buffer_peek_memory(in, static_cast<guint>(i)));
    sources_[i].buffer = {};
  }
  if (!gst::can_be_written(out.get())) {  // reliable only for the sole reference
    for (auto& source : sources_) source.buffer = gst::Ref<GstBuffer>::share(out.get());
    return {};
  }
  const auto remove = [](GstBuffer*, GstMeta** meta, gpointer) -> gboolean {
    *meta = nullptr;
    return TRUE;
  };
  gst_buffer_foreach_meta(out.get(), remove, nullptr);
  return out;
}

Status FrameTransformer::run_fused(GstBuffer* out, Ledger* ledger) {
  const bool in_place = !sources_[0].buffer;
  if (!in_place)
    if (auto status = writer_.map(pool_, out); !status) return status;
  for (size_t i = 0; i < sources_.size(); ++i) {
    const auto& source = sources_[i];
    const gst::MappedMemory in(
        gst_buffer_peek_memory(in_place ? out : source.buffer.get(), source.memory),
        in_place ? GST_MAP_READWRITE : GST_MAP_READ);
    if (!in) return source_not_mapped(source.memory);
    const auto target = in_place ? in.bytes() : writer_.payloads()[i];
    apply(*source.plan, in.bytes(), target, ledger);
  }
  return ok();
}

}  // namespace weir
