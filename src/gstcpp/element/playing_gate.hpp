// PlayingGate: lets a sink's render() wait for a peer in PLAYING only.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/base/gstbasesink.h>

#include <atomic>

namespace weir::gst {

// render() holds the preroll lock, which changes of state need. gst_base_sink_wait_preroll() gives
// it up, but also returns when the sink was paused again before its thread woke, and the base class
// lets render() run before its change to PLAYING has returned.
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

  // For render(): calls `attempt` in PLAYING, again after each pause and flush that made it return
  // false. GST_FLOW_FLUSHING after a flush and on the way to READY: the buffer is lost.
  template <class Attempt>
  GstFlowReturn until_done(GstBaseSink* sink, Attempt attempt) const {
    while (!playing_ || !attempt())
      if (const GstFlowReturn flow = gst_base_sink_wait_preroll(sink); flow != GST_FLOW_OK)
        return flow;
    return GST_FLOW_OK;
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
