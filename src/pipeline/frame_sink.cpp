// SPDX-License-Identifier: LGPL-2.1-or-later
#include "pipeline/frame_sink.hpp"

#include <gst/app/app.h>

#include "core/process/sink_data.hpp"
#include "gstcpp/element/error.hpp"
#include "gstcpp/element/log.hpp"
#include "gstcpp/element/result_events.hpp"

namespace weir::pipeline {
namespace {

constexpr size_t kFramesOfATensorSink = 64;  // documented in pipeline.h

}  // namespace

FrameSink::FrameSink(gst::Ref<GstElement> element, infer::CallGate& callbacks)
    : element_(std::move(element)),
      pad_(gst::Ref<GstPad>::adopt(gst_element_get_static_pad(element_.get(), "sink"))),
      callbacks_(callbacks) {
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
  constexpr int kProbed = GST_PAD_PROBE_TYPE_BUFFER | GST_PAD_PROBE_TYPE_BUFFER_LIST |
                          GST_PAD_PROBE_TYPE_EVENT_DOWNSTREAM | GST_PAD_PROBE_TYPE_EVENT_FLUSH;
  probe_ = gst_pad_add_probe(pad_.get(), GstPadProbeType(kProbed), on_pad, this, nullptr);
}

FrameSink::~FrameSink() {
  gst_pad_remove_probe(pad_.get(), probe_);
  for (const gulong handler : handlers_) g_signal_handler_disconnect(element_.get(), handler);
}

void FrameSink::open() {
  labels_.reset();
  if (!GST_IS_APP_SINK(element_.get())) return queue_.open(kFramesOfATensorSink, Full::Waits);
  auto* sink = GST_APP_SINK(element_.get());
  queue_.open(gst_app_sink_get_max_buffers(sink),
              gst_app_sink_get_drop(sink) ? Full::DropsOldest : Full::Waits);
}

void FrameSink::on_tensors(GstElement*, GstBuffer* buffer, FrameSink* self) {
  self->arrived({gst::Ref<GstBuffer>::share(buffer),
                 gst::Ref<GstCaps>::adopt(gst_pad_get_current_caps(self->pad_.get()))});
}

GstFlowReturn FrameSink::on_sample(GstElement* element, FrameSink* self) {
  // The signal means that a sample is available, unless the sink was flushed meanwhile.
  const gst::Unique<GstSample, gst_sample_unref> sample(
      gst_app_sink_try_pull_sample(GST_APP_SINK(element), 0));
  if (sample)
    self->arrived({gst::Ref<GstBuffer>::share(gst_sample_get_buffer(sample.get())),
                   gst::Ref<GstCaps>::share(gst_sample_get_caps(sample.get()))});
  return GST_FLOW_OK;
}

// A full queue blocks the stream here, before the sink takes its preroll lock: a state change needs
// that lock and must not wait for a pull.
GstPadProbeReturn FrameSink::on_pad(GstPad* pad, GstPadProbeInfo* info, gpointer data) {
  auto* self = static_cast<FrameSink*>(data);
  if (GST_PAD_PROBE_INFO_TYPE(info) & GST_PAD_PROBE_TYPE_EVENT_FLUSH)
    self->queue_.flush();
  else if (GST_PAD_PROBE_INFO_TYPE(info) & GST_PAD_PROBE_TYPE_EVENT_DOWNSTREAM)
    self->took_event(GST_PAD_PROBE_INFO_EVENT(info));
  else if (!self->function_ && !self->is_discarding_)
    self->queue_.wait_for_room([pad] { return GST_PAD_IS_FLUSHING(pad); });
  return GST_PAD_PROBE_OK;
}

void FrameSink::took_event(GstEvent* event) {
  auto labels = gst::parse_labels_event(event);
  if (!labels) return;
  auto all = labels_ ? std::make_shared<Labels>(*labels_) : std::make_shared<Labels>();
  (*all)[labels->source] = std::move(labels->labels);
  labels_ = std::move(all);
}

void FrameSink::on_end(GstElement*, FrameSink* self) {
  self->queue_.end();
}

void FrameSink::arrived(Arrived frame) {
  if (!frame.buffer || is_discarding_) return;
  frame.labels = labels_;
  if (!function_) return queue_.put(std::move(frame));
  const infer::CallGate::Visit visit(callbacks_);
  if (!visit) return;
  const auto read =
      PulledFrame::read(std::move(frame.buffer), std::move(frame.caps), std::move(frame.labels));
  if (!read && g_object_get_data(G_OBJECT(element_.get()), process::kDropsUnreadable)) {
    GST_CAT_WARNING_OBJECT(gst::library_category(), element_.get(), "a frame is dropped: %s",
                           read.error().message().c_str());
    return;
  }
  const Status status = read ? function_(*read) : Status(read.error());
  if (!status) gst::post_error(element_.get(), status.error());
}

}  // namespace weir::pipeline
