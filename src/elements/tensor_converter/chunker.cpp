// A GstAdapter with exact time.
#include "elements/tensor_converter/chunker.hpp"

namespace weir {
namespace {

bool known(const Fraction& rate) {
  return rate.valid() && rate.numerator > 0;
}

GstClockTime time_of(uint64_t frames, const Fraction& rate) {
  return gst_util_uint64_scale(frames, static_cast<guint64>(rate.denominator) * GST_SECOND,
                               static_cast<guint64>(rate.numerator));
}

}  // namespace

void Chunker::configure(size_t frame_bytes, uint64_t frames_out, Fraction rate) {
  frame_bytes_ = frame_bytes;
  frames_out_ = frames_out;
  rate_ = rate;
}

void Chunker::clear() {
  gst_adapter_clear(adapter_.get());
  whole_ = {};
  next_pts_ = GST_CLOCK_TIME_NONE;
}

void Chunker::stamp(GstBuffer* buffer, uint64_t frames, GstClockTime fallback) {
  if (!GST_BUFFER_DURATION_IS_VALID(buffer) && known(rate_))
    GST_BUFFER_DURATION(buffer) = time_of(frames, rate_);
  if (!GST_BUFFER_PTS_IS_VALID(buffer)) {
    const bool follows = known(rate_) && GST_CLOCK_TIME_IS_VALID(next_pts_);
    GST_BUFFER_PTS(buffer) = follows ? next_pts_ : fallback;
  }
  if (GST_BUFFER_PTS_IS_VALID(buffer) && GST_BUFFER_DURATION_IS_VALID(buffer))
    next_pts_ = GST_BUFFER_PTS(buffer) + GST_BUFFER_DURATION(buffer);
}

void Chunker::push(gst::Ref<GstBuffer> buffer) {
  const size_t bytes = gst_buffer_get_size(buffer.get());
  duration_of_input_ = GST_BUFFER_DURATION(buffer.get());
  frames_of_input_ = bytes / frame_bytes_;
  if (gst_adapter_available(adapter_.get()) == 0 && frames_of_input_ == frames_out_)
    whole_ = std::move(buffer);
  else
    gst_adapter_push(adapter_.get(), buffer.release());
}

gst::Ref<GstBuffer> Chunker::next() {
  if (whole_) return std::exchange(whole_, {});
  const size_t wanted = frame_bytes_ * frames_out_;
  if (gst_adapter_available(adapter_.get()) < wanted) return {};
  guint64 pts_distance = 0, dts_distance = 0;
  GstClockTime pts = gst_adapter_prev_pts(adapter_.get(), &pts_distance);
  GstClockTime dts = gst_adapter_prev_dts(adapter_.get(), &dts_distance);
  if (known(rate_)) {
    if (GST_CLOCK_TIME_IS_VALID(pts)) pts += time_of(pts_distance / frame_bytes_, rate_);
    if (GST_CLOCK_TIME_IS_VALID(dts)) dts += time_of(dts_distance / frame_bytes_, rate_);
  }
  auto out = gst::Ref<GstBuffer>::adopt(gst_adapter_take_buffer(adapter_.get(), wanted));
  out = gst::Ref<GstBuffer>::adopt(gst_buffer_make_writable(out.release()));
  GST_BUFFER_PTS(out.get()) = pts;
  GST_BUFFER_DTS(out.get()) = dts;
  if (GST_CLOCK_TIME_IS_VALID(duration_of_input_))
    GST_BUFFER_DURATION(out.get()) =
        gst_util_uint64_scale(duration_of_input_, frames_out_, frames_of_input_);
  return out;
}

}  // namespace weir
