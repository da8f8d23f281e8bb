// FrameSink: a tensor_sink or appsink, and the frames that it delivers.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/infer/queue/call_gate.hpp"
#include "gstcpp/element/ref.hpp"
#include "pipeline/frame_queue.hpp"
#include "pipeline/pulled_frame.hpp"

namespace weir::pipeline {

class FrameSink {
 public:
  struct Arrived {
    gst::Ref<GstBuffer> buffer;
    gst::Ref<GstCaps> caps;
    std::shared_ptr<const Labels> labels = {};
  };
  using Queue = FrameQueue<Arrived>;
  using Function = std::function<Status(const std::shared_ptr<const PulledFrame>&)>;

  static bool is_sink(const std::string& kind) {
    return kind == "tensor_sink" || kind == "appsink";
  }
  // The function of set_function() is called through the gate `callbacks`.
  FrameSink(gst::Ref<GstElement> element, infer::CallGate& callbacks);
  ~FrameSink();  // Precondition: the element is stopped.
  FrameSink(const FrameSink&) = delete;
  FrameSink& operator=(const FrameSink&) = delete;

  Queue& queue() noexcept { return queue_; }
  // Whether the element is a child of this bin, and not of one in it.
  bool is_in(const GstElement* bin) const { return GST_ELEMENT_PARENT(element_.get()) == bin; }
  // Opens the queue with the limits of the element's properties.
  void open();
  // Call while the element is stopped.
  void set_function(Function function) {
    function_ = std::move(function);
    is_discarding_ = false;
  }
  // Drops frames unread until the next set_function(). Call while the element is stopped.
  void discard() noexcept { is_discarding_ = true; }

 private:
  static void on_tensors(GstElement* element, GstBuffer* buffer, FrameSink* self);
  static GstFlowReturn on_sample(GstElement* element, FrameSink* self);
  static void on_end(GstElement* element, FrameSink* self);
  static GstPadProbeReturn on_pad(GstPad* pad, GstPadProbeInfo* info, gpointer self);
  void took_event(GstEvent* event);
  void arrived(Arrived frame);

  gst::Ref<GstElement> element_;
  gst::Ref<GstPad> pad_;
  infer::CallGate& callbacks_;
  std::vector<gulong> handlers_;
  gulong probe_ = 0;
  Queue queue_;
  Function function_;  // empty: frames are queued
  bool is_discarding_ = false;
  // Replaced, not changed: frames share it. Guarded by the pad's stream lock; open() runs while
  // the element is stopped.
  std::shared_ptr<const Labels> labels_;
};

}  // namespace weir::pipeline
