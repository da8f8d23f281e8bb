// Shares memory for windows that are contiguous in a buffer; otherwise copies each byte once.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_aggregator/window_stream.hpp"

#include <algorithm>
#include <tuple>

#include "gstcpp/buffer/memory_part.hpp"
#include "gstcpp/buffer/tensor_meta.hpp"

namespace weir {
namespace {

using gst::Ref;

auto fields(const SourceMap& m) {
  return std::tie(m.xx, m.xy, m.x0, m.yx, m.yy, m.y0, m.source_width, m.source_height, m.width,
                  m.height, m.x_dimension, m.y_dimension);
}
bool same_maps(GstBuffer* a, GstBuffer* b) {
  const auto left = gst::source_maps(a), right = gst::source_maps(b);
  return gst::maps_of(a) == gst::maps_of(b) &&
         std::equal(left.begin(), left.end(), right.begin(), right.end(),
                    [](const auto& x, const auto& y) { return fields(x) == fields(y); });
}

}  // namespace

WindowStream::WindowStream(std::shared_ptr<WindowSetup> setup) : setup_(std::move(setup)) {
  const auto& plan = setup_->plan;
  if (!plan.overlaps() || plan.layouts.size() > kMemoryLimit) return;
  for (const auto& layout : plan.layouts) {
    strips_.push_back(layout.is_plain() ? WindowStrip(layout.frame_bytes, plan.out)
                                        : WindowStrip());
    blocks_.push_back(layout.is_plain() ? nullptr : StripPool::make(layout.frame_bytes * plan.out));
  }
}

Status WindowStream::push(Ref<GstBuffer> buffer, Ledger* ledger) {
  auto arrived = spare_ ? std::move(spare_) : std::make_unique<Arrived>();
  if (auto status = arrived->reader.read(buffer.get(), setup_->input); !status) return status;
  ledger->copied(arrived->reader.bytes_copied());
  if (GST_BUFFER_PTS_IS_VALID(buffer.get())) pts_ = {GST_BUFFER_PTS(buffer.get()), arrived_};
  if (GST_BUFFER_DTS_IS_VALID(buffer.get())) dts_ = {GST_BUFFER_DTS(buffer.get()), arrived_};
  duration_ = GST_BUFFER_DURATION(buffer.get());
  arrived->pts = pts_;
  arrived->dts = dts_;
  arrived->buffer = std::move(buffer);
  arrived_ += setup_->plan.in;
  waiting_.push_back(std::move(arrived));
  // Frames between two windows, when the step is larger than a window.
  forget_before(setup_->plan.begin(windows_), DropReason::Policy, ledger);
  return ok();
}

uint64_t WindowStream::find_last_buffer(uint64_t begin) const noexcept {
  return (begin + setup_->plan.out - 1) / setup_->plan.in;
}

WindowStream::Arrived& WindowStream::find_holder(uint64_t frame) {
  return *waiting_[static_cast<size_t>(frame / setup_->plan.in - first_)];
}

std::span<const std::byte> WindowStream::get_frame(size_t tensor, uint64_t frame) {
  const size_t bytes = setup_->plan.layouts[tensor].frame_bytes;
  return find_holder(frame).reader.tensors()[tensor].payload.subspan(
      static_cast<size_t>(frame % setup_->plan.in) * bytes, bytes);
}

Result<Ref<GstBuffer>> WindowStream::next(Ledger* ledger) {
  const auto& plan = setup_->plan;
  const uint64_t begin = plan.begin(windows_);
  if (begin + plan.out > arrived_) return Ref<GstBuffer>();
  uint64_t copied = 0;
  auto out = leaves_by_memory(begin) ? assembled(begin, &copied) : gathered(begin, &copied);
  if (!out) return out;
  ledger->copied(copied);
  describe(out->get(), begin);
  frames_lost_ += begin - std::min(begin, used_);
  used_ = begin + plan.out;
  ++windows_;
  forget_before(plan.begin(windows_), DropReason::Policy, ledger);
  return out;
}

void WindowStream::forget_before(uint64_t frame, DropReason reason, Ledger* ledger) {
  const auto& plan = setup_->plan;
  while (!waiting_.empty() && (first_ + 1) * plan.in <= frame) {
    // Frames before the last window were already dropped.
    const bool used = first_ * plan.in < used_;
    if (used)
      ledger->consumed();
    else
      ledger->dropped(reason);
    waiting_.front()->reader.clear();
    waiting_.front()->buffer = {};
    spare_ = std::move(waiting_.front());
    waiting_.pop_front();
    ++first_;
  }
}

std::vector<Ref<GstBuffer>> WindowStream::take_back(Ledger* ledger) {
  const auto& plan = setup_->plan;
  const uint64_t begin = plan.begin(windows_);
  forget_before((begin + plan.in - 1) / plan.in * plan.in, DropReason::Policy, ledger);
  std::vector<Ref<GstBuffer>> out;
  for (const auto& arrived : waiting_) {
    arrived->reader.clear();
    out.push_back(std::move(arrived->buffer));
  }
  waiting_.clear();
  return out;
}

void WindowStream::clear(DropReason reason, Ledger* ledger) {
  frames_lost_ += arrived_ - std::min(arrived_, used_);
  forget_before(arrived_, reason, ledger);
  strips_.clear();
  blocks_.clear();
  auto setup = std::move(setup_);
  const auto lost = frames_lost_;
  *this = WindowStream(std::move(setup));
  frames_lost_ = lost;
}

// Whether to output one memory per tensor: windows within a buffer share its memory, and
// overlapping windows share with each other.
bool WindowStream::leaves_by_memory(uint64_t begin) {
  const auto& plan = setup_->plan;
  if (plan.layouts.size() > kMemoryLimit) return false;
  const bool some_plain = std::any_of(plan.layouts.begin(), plan.layouts.end(),
                                      [](const auto& layout) { return layout.is_plain(); });
  if (plan.overlaps() && some_plain) return true;
  if (begin / plan.in != find_last_buffer(begin)) return false;
  const auto& views = find_holder(begin).reader.tensors();
  for (size_t i = 0; i < views.size(); ++i)
    if (views[i].memory < 0 || !plan.layouts[i].is_plain()) return false;
  return true;
}

Result<Ref<GstMemory>> WindowStream::part_of_input(size_t tensor, uint64_t begin,
                                                   uint64_t* copied) {
  const auto& plan = setup_->plan;
  const size_t bytes = plan.layouts[tensor].frame_bytes;
  if (begin / plan.in != find_last_buffer(begin)) return Ref<GstMemory>();
  Arrived& holder = find_holder(begin);
  const int memory = holder.reader.tensors()[tensor].memory;
  if (memory < 0) return Ref<GstMemory>();
  return gst::make_part(gst_buffer_peek_memory(holder.buffer.get(), static_cast<guint>(memory)),
                        begin % plan.in * bytes, plan.out * bytes, copied);
}

void WindowStream::place_all(size_t tensor, uint64_t begin, std::span<std::byte> out,
                             uint64_t* copied) {
  const auto& plan = setup_->plan;
  for (uint64_t i = 0; i < plan.out; ++i)
    window::place(plan.layouts[tensor], i, plan.out, get_frame(tensor, begin + i), out);
  *copied += out.size();
}

Result<Ref<GstBuffer>> WindowStream::assembled(uint64_t begin, uint64_t* copied) {
  const auto& plan = setup_->plan;
  auto out = Ref<GstBuffer>::adopt(gst_buffer_new());
  for (size_t i = 0; i < plan.layouts.size(); ++i) {
    const window::WindowLayout& layout = plan.layouts[i];
    const size_t bytes = layout.frame_bytes * static_cast<size_t>(plan.out);
    auto part = layout.is_plain() ? part_of_input(i, begin, copied) : Ref<GstMemory>();
    if (!part) return part.error();
    GstMemory* memory = part->release();
    if (!memory && layout.is_plain() && !strips_.empty())
      memory = strips_[i].window(
          begin, [&](uint64_t frame) { return get_frame(i, frame); }, copied);
    if (!memory) {
      auto block =
          blocks_.empty() || !blocks_[i] ? StripPool::make(bytes)->take() : blocks_[i]->take();
      place_all(i, begin, {block.get(), bytes}, copied);
      memory = part_of_block(std::move(block), 0, bytes);
    }
    gst_buffer_append_memory(out.get(), memory);
  }
  return out;
}

Result<Ref<GstBuffer>> WindowStream::gathered(uint64_t begin, uint64_t* copied) {
  auto out = setup_->pool.acquire();
  if (!out) return out;
  if (auto status = writer_.map(setup_->pool, out->get()); !status) return status.error();
  for (size_t i = 0; i < setup_->plan.layouts.size(); ++i)
    place_all(i, begin, writer_.payloads()[i], copied);
  writer_.unmap();
  return out;
}

// Times follow docs/compatibility/routing.md 6.6; flags and metas come from the buffer in which the
// window begins.
void WindowStream::describe(GstBuffer* out, uint64_t begin) {
  const auto& plan = setup_->plan;
  const Arrived& holder = find_holder(begin);
  gst_buffer_copy_into(out, holder.buffer.get(),
                       GstBufferCopyFlags(GST_BUFFER_COPY_FLAGS | GST_BUFFER_COPY_META), 0,
                       static_cast<gsize>(-1));
  if (begin % plan.in != 0) GST_BUFFER_FLAG_UNSET(out, GST_BUFFER_FLAG_DISCONT);
  const auto at = [&](const KnownTime& known) {
    if (!GST_CLOCK_TIME_IS_VALID(known.time) || plan.in == 1) return known.time;
    return known.time + window::to_time(begin - known.frame, setup_->input.rate);
  };
  GST_BUFFER_PTS(out) = at(holder.pts);
  GST_BUFFER_DTS(out) = at(holder.dts);
  GST_BUFFER_DURATION(out) = GST_CLOCK_TIME_IS_VALID(duration_)
                                 ? gst_util_uint64_scale(duration_, plan.out, plan.in)
                                 : GST_CLOCK_TIME_NONE;
  const auto maps = gst::source_maps(out);
  if (maps.empty()) return;
  // The source map stays valid only if all frames have the same and pixels keep their places.
  bool stays = gst::maps_of(out) == gst::MapsOf::Tensors;
  for (const auto& map : maps)
    stays = stays && setup_->dimension != map.x_dimension && setup_->dimension != map.y_dimension;
  for (uint64_t i = begin / plan.in + 1; stays && i <= find_last_buffer(begin); ++i)
    stays = same_maps(out, waiting_[static_cast<size_t>(i - first_)]->buffer.get());
  if (!stays) gst::set_source_maps(out, {});
}

}  // namespace weir
