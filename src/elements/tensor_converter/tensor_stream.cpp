// TensorStream: the stream of tensors that tensor_converter makes of the caps of its input.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_converter/tensor_stream.hpp"

#include <gst/gst.h>

#include <vector>

#include "core/ledger/ledger.hpp"
#include "core/tensor/frame_spec.hpp"
#include "elements/tensor_converter/negotiation.hpp"
#include "gstcpp/buffer/frame_errors.hpp"
#include "gstcpp/buffer/tensor_meta.hpp"
#include "gstcpp/element/ref.hpp"

namespace weir {

using gst::Ref;

Status TensorStream::configure(const GstCaps* caps, const ConverterSettings& settings,
                               const ConverterMode& mode, bool goes_on, const GstBuffer* next) {
  medium_.reset();
  auto medium = medium_for(caps, mode);
  if (!medium) return medium.error();
  const gst::PeerCaps peer(source_);
  auto wanted = read_preferences(settings, peer);
  if (!wanted) return wanted.error();
  wanted->limit = &limit_;
  auto plan = (*medium)->configure(caps, *wanted);
  if (!plan) return plan.error();
  if (next)
    if (auto status = (*medium)->accepts(next); !status) return status.error();
  if (auto status = take(*std::move(plan), peer, (*medium)->type(), goes_on); !status)
    return status;
  medium_ = *std::move(medium);
  medium_->allocate_as(allocation_);
  medium_->defer_with(deferral_ ? counts_ : nullptr);
  return ok();
}

void TensorStream::reset() {
  medium_.reset();
  allocation_ = {};
  headered_.clear();
  waits_for_frame_ = false;
  held_segment_ = {};
}

void TensorStream::flush() {
  if (medium_) medium_->reset();
  held_segment_ = {};
}

Result<MediumFrames> TensorStream::convert(Ref<GstBuffer> buffer) {
  if (!medium_)
    return Error{.code = Code::NOT_NEGOTIATED,
                 .what = "a buffer arrived before caps",
                 .needed = "caps",
                 .fix = "put a capsfilter downstream of the source"};
  if (gst_buffer_get_size(buffer.get()) == 0)
    return Error{.code = Code::FRAME_SIZE,
                 .what = "a buffer is empty",
                 .offered = "0 bytes",
                 .needed = "at least one frame",
                 .fix = "check the upstream element"};
  auto frames = medium_->frames(std::move(buffer), &ledger_);
  if (!frames || frames->tensors.empty()) return frames;
  const Format format = frames->is_flexible ? Format::Flexible : planned_format_;
  const bool other_format = format != plan_.spec.format;
  const bool changed =
      other_format || !first_difference(frames->tensors, plan_.spec.tensors).empty();
  const bool paced = frames->rate && !(*frames->rate == plan_.spec.rate);
  FrameSpec before = plan_.spec;
  plan_.spec.tensors = frames->tensors;
  plan_.spec.format = format;
  has_headers_ = frames->has_headers;
  if (paced) plan_.spec.rate = *frames->rate;
  if (changed) drop_waiting();
  const bool known = !changed || (!other_format && format == Format::Flexible);
  if (!paced && known && !waits_for_frame_) return frames;
  const Status status = announce(gst::PeerCaps(source_));
  if (status) return frames;
  plan_.spec = std::move(before);
  return status.error();
}

Result<Ref<GstBuffer>> TensorStream::make_output(Ref<GstBuffer> frames) {
  auto made = has_headers_ ? Result(std::move(frames))
              : output_format_ == Format::Flexible
                  ? headered_.copy(frames.get(), plan_.spec.tensors, medium_->type(), &ledger_)
                  : one_memory_each(std::move(frames), plan_.spec.tensors, &ledger_);
  if (!made || !plan_.picture) return made;
  auto buffer = Ref<GstBuffer>::adopt(gst_buffer_make_writable(made->release()));
  if (!buffer) return gst::memory_not_mapped();
  gst::set_source_maps(buffer.get(), {*plan_.picture});
  return buffer;
}

gboolean TensorStream::send_segment(Ref<GstEvent> segment) {
  if (!waits_for_frame_) return gst_pad_push_event(source_, segment.release());
  held_segment_ = std::move(segment);
  return TRUE;
}

void TensorStream::offer(GstQuery* query) const {
  gst::offer(query, allocation_);
  medium_->offer(query);
}

// Makes the plan that of the stream, and announces it unless it is known downstream or waits for a
// frame.
Status TensorStream::take(StreamPlan plan, const gst::PeerCaps& peer, MediaType type,
                          bool goes_on) {
  const bool keeps = goes_on && plan.first_frame_decides && plan.spec.format == planned_format_;
  planned_format_ = plan.spec.format;
  if (keeps) plan.spec = plan_.spec;
  // Audio of another rate cannot share a tensor; pictures of another rate can.
  const bool resampled = type == MediaType::Audio && !(plan.spec.rate == plan_.spec.rate);
  if (resampled || plan.frame_bytes != plan_.frame_bytes || plan.frames_out != plan_.frames_out ||
      !first_difference(plan.spec.tensors, plan_.spec.tensors).empty())
    drop_waiting();
  plan_ = std::move(plan);
  has_headers_ = false;
  // Downstream need not accept a placeholder.
  if (!keeps)
    waits_for_frame_ =
        (plan_.first_frame_decides || plan_.frames_have_rates) &&
        !gst::downstream_accepts(source_, peer, gst::choose_caps(source_, peer, plan_.spec).get());
  if (!keeps && !waits_for_frame_)
    if (auto status = announce(peer); !status) return status;
  if (plan_.frame_bytes > 0)
    waiting_.configure(plan_.frame_bytes, plan_.frames_out, plan_.spec.rate);
  return ok();
}

// Chooses and sends the caps of the plan's tensors.
Status TensorStream::announce(const gst::PeerCaps& peer) {
  auto out = gst::choose_caps(source_, peer, plan_.spec);
  if (auto status = gst::send_caps(source_, plan_.spec, out.get()); !status) return status;
  const auto chosen = gst::spec_from_caps(out.get());
  if (!chosen) return chosen.error();
  output_format_ = chosen->format;
  waits_for_frame_ = false;
  if (held_segment_) gst_pad_push_event(source_, held_segment_.release());
  if (GST_PAD_IS_FLUSHING(source_)) return ok();  // this element is shutting down
  const auto query = gst::ask_peer(source_, out.get(), ledger_);
  if (query) allocation_ = gst::parse_allocation(query.get(), allocation_);
  deferral_ = query && output_format_ == Format::Static && plan_.frames_out == 1 &&
              gst::deferral_is_offered(query.get(), source_);
  return ok();
}

// A tensor cannot mix frames of different kinds; timestamps continue.
void TensorStream::drop_waiting() {
  const uint64_t lost = waiting_.drop();
  if (lost > 0) ledger_.dropped(DropReason::Flush, lost);
}

}  // namespace weir
