// Signals of the two sinks.
#include "pipeline/frame_sink.hpp"

#include <gst/app/app.h>

#include "gstcpp/error.hpp"

namespace weir::pipeline {
namespace {

constexpr size_t kFramesOfATensorSink = 64;  // pipeline.h says it

}  // namespace

FrameSink::FrameSink(gst::Ref<GstElement> element) : element_(std::move(element)) {
  const auto connect = [this](const char* signal, GCallback function) {
    handlers_.push_back(g_signal_connect(element_.get(), signal, function, this));
  };
  if (GST_IS_APP_SINK(element_.get())) {
    gst_app_sink_set_emit_signals(GST_APP_SINK(element_.get()), TRUE);
    connect("new-sample", G_CALLBACK(on_sample));
  } else {
    connect("new-data", G_CALLBACK(on_tensors));
  }
  connect("eos", G_CALLBACK(on_end));
}

FrameSink::~FrameSink() {
  for (const gulong handler : handlers_) g_signal_handler_disconnect(element_.get(), handler);
}

void FrameSink::open() {
  if (!GST_IS_APP_SINK(element_.get())) return queue_.open(kFramesOfATensorSink, Full::Waits);
  auto* sink = GST_APP_SINK(element_.get());
  queue_.open(gst_app_sink_get_max_buffers(sink),
              gst_app_sink_get_drop(sink) ? Full::DropsOldest : Full::Waits);
}

void FrameSink::on_tensors(GstElement* element, GstBuffer* buffer, FrameSink* self) {
  const auto pad = gst::Ref<GstPad>::adopt(gst_element_get_static_pad(element, "sink"));
  self->arrived({gst::Ref<GstBuffer>::share(buffer),
                 gst::Ref<GstCaps>::adopt(gst_pad_get_current_caps(pad.get()))});
}

GstFlowReturn FrameSink::on_sample(GstElement* element, FrameSink* self) {
  // There is one: this is called for it. None when the sink was flushed in between.
  const gst::Unique<GstSample, gst_sample_unref> sample(
      gst_app_sink_try_pull_sample(GST_APP_SINK(element), 0));
  if (sample)
    self->arrived({gst::Ref<GstBuffer>::share(gst_sample_get_buffer(sample.get())),
                   gst::Ref<GstCaps>::share(gst_sample_get_caps(sample.get()))});
  return GST_FLOW_OK;
}

void FrameSink::on_end(GstElement*, FrameSink* self) {
  self->queue_.end();
}

void FrameSink::arrived(Arrived frame) {
  if (!frame.buffer) return;
  if (!function_) return queue_.put(std::move(frame));
  const auto read = PulledFrame::read(std::move(frame.buffer), frame.caps);
  const Status status = read ? function_(*read) : Status(read.error());
  if (!status) gst::post_error(element_.get(), status.error());
}

}  // namespace weir::pipeline
