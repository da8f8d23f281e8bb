// PlayingGate: where a sink's render() waits in PAUSED after its own wait was interrupted.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/base/gstbasesink.h>

#include <atomic>

namespace weir::gst {

// gst_base_sink_wait_preroll() alone also returns when the sink was paused again before its thread
// woke. The next wait of render() would then hold the preroll lock, which the change to PLAYING
// needs.
class PlayingGate {
 public:
  // The sink's change_state(), with `parent` for that of the base class.
  template <class Parent>
  GstStateChangeReturn change_state(GstBaseSink* sink, GstStateChange change, Parent parent) {
    if (change == GST_STATE_CHANGE_PLAYING_TO_PAUSED) playing_ = false;
    const GstStateChangeReturn result = parent();
    if (change == GST_STATE_CHANGE_PAUSED_TO_PLAYING && result != GST_STATE_CHANGE_FAILURE)
      open(sink);
    return result;
  }

  // For render(). GST_FLOW_OK in PLAYING: it tries the same buffer again. GST_FLOW_FLUSHING after a
  // flush and on the way to READY: the buffer is lost.
  GstFlowReturn wait(GstBaseSink* sink) const {
    GstFlowReturn flow = GST_FLOW_OK;
    do flow = gst_base_sink_wait_preroll(sink);
    while (flow == GST_FLOW_OK && !playing_);
    return flow;
  }

 private:
  void open(GstBaseSink* sink) {
    GST_BASE_SINK_PREROLL_LOCK(sink);
    playing_ = true;
    GST_BASE_SINK_PREROLL_SIGNAL(sink);
    GST_BASE_SINK_PREROLL_UNLOCK(sink);
  }

  std::atomic<bool> playing_{false};
};

}  // namespace weir::gst
