// Chunker: a GstAdapter with exact timestamps.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_converter/chunker.hpp"

#include "gstcpp/buffer/allocation.hpp"
#include "gstcpp/buffer/frame_errors.hpp"
#include "gstcpp/buffer/memory_part.hpp"

namespace weir {
bool known(const Fraction& rate) noexcept {
  return rate.valid() && rate.numerator > 0;
}

GstClockTime to_time(uint64_t frames, const Fraction& rate) noexcept {
  return gst_util_uint64_scale(frames, static_cast<guint64>(rate.denominator) * GST_SECOND,
                               static_cast<guint64>(rate.numerator));
}

namespace {

// Adds `by`; GST_CLOCK_TIME_NONE on overflow.
GstClockTime later(GstClockTime time, GstClockTime by) noexcept {
  GstClockTime sum = 0;
  return __builtin_add_overflow(time, by, &sum) ? GST_CLOCK_TIME_NONE : sum;
}

}  // namespace

void Chunker::configure(size_t frame_bytes, uint64_t frames_out, Fraction rate) {
  frame_bytes_ = frame_bytes;
  frames_out_ = frames_out;
  if (!(rate == rate_)) keep_time_of_next();
  // At a new rate, frames are counted from the end of the previous ones.
  if (!(rate == rate_) && GST_CLOCK_TIME_IS_VALID(anchor_) && known(rate_)) {
    anchor_ = later(anchor_, to_time(frames_since_, rate_));
    frames_since_ = 0;
  }
  rate_ = rate;
}

uint64_t Chunker::drop() {
  const uint64_t lost = waiting_.size() + (whole_ ? 1 : 0);
  gst_adapter_clear(adapter_.get());
  whole_ = {};
  waiting_.clear();
  return lost;
}

uint64_t Chunker::clear() {
  anchor_ = GST_CLOCK_TIME_NONE;
  return drop();
}

void Chunker::stamp(GstBuffer* buffer, uint64_t frames, GstClockTime fallback) {
  const bool duration_given = GST_BUFFER_DURATION_IS_VALID(buffer);
  duration_is_counted_ = !duration_given && known(rate_);
  if (duration_is_counted_) GST_BUFFER_DURATION(buffer) = to_time(frames, rate_);
  const bool follows = known(rate_) && GST_CLOCK_TIME_IS_VALID(anchor_);
  if (GST_BUFFER_PTS_IS_VALID(buffer) || !follows) {
    if (!GST_BUFFER_PTS_IS_VALID(buffer)) GST_BUFFER_PTS(buffer) = fallback;
    anchor_ = GST_BUFFER_PTS(buffer);
    frames_since_ = 0;
  } else {
    GST_BUFFER_PTS(buffer) = later(anchor_, to_time(frames_since_, rate_));
  }
  frames_since_ += frames;
  if (duration_given && GST_CLOCK_TIME_IS_VALID(anchor_)) {
    anchor_ = later(GST_BUFFER_PTS(buffer), GST_BUFFER_DURATION(buffer));
    frames_since_ = 0;
  }
}

Status Chunker::push(gst::Ref<GstBuffer> buffer, const BufferLimit& limit) {
  const size_t bytes = gst_buffer_get_size(buffer.get());
  const bool whole = waiting_.empty() && bytes / frame_bytes_ == frames_out_;
  const size_t wanted = frame_bytes_ * frames_out_;
  if (!whole && wanted > bytes)
    if (auto status = limit.check(wanted); !status) return status;
  if (!whole && !gst::can_be_read(buffer.get())) return gst::memory_not_mapped();
  duration_of_input_ = GST_BUFFER_DURATION(buffer.get());
  frames_of_input_ = bytes / frame_bytes_;
  if (whole) {
    whole_ = std::move(buffer);
  } else {
    gst_adapter_push(adapter_.get(), buffer.release());
    waiting_.push_back(bytes);
  }
  return ok();
}

void Chunker::finish(size_t bytes) {
  while (!waiting_.empty() && bytes >= waiting_.front()) {
    bytes -= waiting_.front();
    waiting_.pop_front();
    ++finished_;
  }
  if (!waiting_.empty()) waiting_.front() -= bytes;
}

Chunker::Times Chunker::times_of_next() const {
  guint64 pts_distance = 0, dts_distance = 0;
  Times out{gst_adapter_prev_pts(adapter_.get(), &pts_distance),
            gst_adapter_prev_dts(adapter_.get(), &dts_distance)};
  if (!known(rate_)) return out;
  if (GST_CLOCK_TIME_IS_VALID(out.pts))
    out.pts = later(out.pts, to_time(pts_distance / frame_bytes_, rate_));
  if (GST_CLOCK_TIME_IS_VALID(out.dts))
    out.dts = later(out.dts, to_time(dts_distance / frame_bytes_, rate_));
  return out;
}

void Chunker::keep_time_of_next() {
  const size_t bytes = gst_adapter_available(adapter_.get());
  if (bytes == 0) return;
  const auto [pts, dts] = times_of_next();
  GstBufferList* waiting = gst_adapter_take_buffer_list(adapter_.get(), bytes);
  for (guint i = 0; i < gst_buffer_list_length(waiting); ++i) {
    GstBuffer* buffer = gst_buffer_ref(gst_buffer_list_get(waiting, i));
    if (i == 0) {
      buffer = gst_buffer_make_writable(buffer);
      GST_BUFFER_PTS(buffer) = pts;
      GST_BUFFER_DTS(buffer) = dts;
    }
    gst_adapter_push(adapter_.get(), buffer);
  }
  gst_buffer_list_unref(waiting);
}

// Replaces GstAdapter's own copy, which aborts the process when memory runs out.
Result<gst::Ref<GstBuffer>> Chunker::gather(size_t bytes) {
  auto out = gst::allocate_buffer(bytes);
  if (!out) return out;
  const gst::Mapped map(out->get(), GST_MAP_WRITE);
  if (!map) return gst::memory_ran_out(bytes);
  gst_adapter_copy(adapter_.get(), map.bytes().data(), 0, bytes);
  GstBufferList* parts = gst_adapter_take_buffer_list(adapter_.get(), bytes);
  for (guint i = 0; i < gst_buffer_list_length(parts); ++i)
    gst_buffer_copy_into(out->get(), gst_buffer_list_get(parts, i), GST_BUFFER_COPY_META, 0,
                         static_cast<gsize>(-1));
  gst_buffer_list_unref(parts);
  copied_ += bytes;
  return out;
}

Result<gst::Ref<GstBuffer>> Chunker::next() {
  if (whole_) {
    ++finished_;
    return std::exchange(whole_, {});
  }
  const size_t wanted = frame_bytes_ * frames_out_;
  if (gst_adapter_available(adapter_.get()) < wanted) return gst::Ref<GstBuffer>();
  const auto [pts, dts] = times_of_next();
  gst::Ref<GstBuffer> out;
  if (waiting_.front() < wanted) {
    auto gathered = gather(wanted);
    if (!gathered) return gathered;
    out = *std::move(gathered);
  } else {
    out = gst::Ref<GstBuffer>::adopt(gst_adapter_take_buffer(adapter_.get(), wanted));
  }
  finish(wanted);
  out = gst::Ref<GstBuffer>::adopt(gst_buffer_make_writable(out.release()));
  GST_BUFFER_PTS(out.get()) = pts;
  GST_BUFFER_DTS(out.get()) = dts;
  if (duration_is_counted_)
    GST_BUFFER_DURATION(out.get()) = to_time(frames_out_, rate_);
  else if (GST_CLOCK_TIME_IS_VALID(duration_of_input_))
    GST_BUFFER_DURATION(out.get()) =
        gst_util_uint64_scale(duration_of_input_, frames_out_, frames_of_input_);
  return out;
}

}  // namespace weir
