// PairedTransform<Impl, Pad>: a CountedTransform of pictures with a second sink pad `results`,
// whose frames are paired with the pictures.
//
// `Pad` derives from PairedTensors. In addition to what CountedTransform requires, Impl has
//   kPads[2]                                        the template of the pad
//   Settings with sync, max_age and max_wait
//   Status start_results(const Settings&)           READY->PAUSED: starts `results_`
// and, where it has these functions of its own, calls those of this class from them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <utility>

#include "gstcpp/element/counted_transform.hpp"
#include "gstcpp/pads/paired_tensors.hpp"
#include "gstcpp/pads/streaming_threads.hpp"

namespace weir::gst {

template <class Impl, class Pad>
class PairedTransform : public CountedTransform<Impl> {
 public:
  void constructed() {
    using Shell = Element<Impl, BaseTransform>;
    results_pad_ = gst_pad_new_from_static_template(&Impl::kPads[2], "results");
    gst_pad_set_chain_function(results_pad_, (Shell::template chain<&Impl::results_chain>));
    gst_pad_set_event_function(results_pad_, (Shell::template pad_event<&Impl::results_event>));
    // Results are not forwarded: queries end at this pad too.
    gst_pad_set_iterate_internal_links_function(
        results_pad_, [](GstPad*, GstObject*) -> GstIterator* { return nullptr; });
    gst_element_add_pad(this->element(), results_pad_);
  }

  bool stop() {
    found_.reset();
    return true;
  }

  // A picture that waits for results must not block the deactivation of the pads.
  GstStateChangeReturn change_state(GstStateChange change) {
    if (change == GST_STATE_CHANGE_READY_TO_PAUSED) {
      const auto s = this->settings();
      if (const Status status = static_cast<Impl*>(this)->start_results(s); !status) {
        post_error(this->element(), status.error());
        return GST_STATE_CHANGE_FAILURE;
      }
      limits_ = {s.max_age, s.max_wait};
      same_time_ = s.sync == ResultsSync::SameTime;
      latency_ = same_time_ ? s.max_wait : 0;
      is_stall_checked_ = false;
    }
    if (change == GST_STATE_CHANGE_PAUSED_TO_READY) results_.stop();
    const auto result =
        GST_ELEMENT_CLASS(this->parent_class())->change_state(this->element(), change);
    if (change == GST_STATE_CHANGE_PAUSED_TO_READY) results_.forget_stream();
    return result;
  }

  GstFlowReturn results_chain(GstBuffer* raw) {
    const auto buffer = Ref<GstBuffer>::adopt(raw);
    if (const Status status = results_.receive_counted(buffer.get()); !status) {
      post_error(this->element(), status.error());
      return GST_FLOW_ERROR;
    }
    return GST_FLOW_OK;
  }
  gboolean results_event(GstPad*, GstEvent* raw) {
    const auto event = Ref<GstEvent>::adopt(raw);
    const Status status = results_.handle(raw);
    if (!status) post_error(this->element(), status.error());
    return status.has_value();
  }

  gboolean sink_event(GstEvent* event) {
    if (GST_EVENT_TYPE(event) == GST_EVENT_FLUSH_START) results_.flush_pictures(true);
    if (GST_EVENT_TYPE(event) == GST_EVENT_FLUSH_STOP) results_.flush_pictures(false);
    return this->parent_class()->sink_event(this->self(), event);
  }

  gboolean query(GstPadDirection direction, GstQuery* query) {
    if (!this->parent_class()->query(this->self(), direction, query)) return FALSE;
    if (direction == GST_PAD_SRC && GST_QUERY_TYPE(query) == GST_QUERY_LATENCY) add_wait(query);
    return TRUE;
  }
  // Pictures are pushed in the memory that they came in: that may be downstream's.
  bool propose_allocation(GstQuery*, GstQuery* query) {
    return gst_pad_peer_query(GST_BASE_TRANSFORM_SRC_PAD(this->self()), query);
  }

 protected:
  // Sets `found_` for a picture. False: the stream is flushing.
  bool take_results(GstBuffer* picture) {
    found_.reset();
    if (same_time_ && !gst_pad_is_linked(results_pad_)) return true;
    const GstClockTime time = running_time(this->self()->segment, GST_BUFFER_PTS(picture));
    const uint64_t late = results_.late();
    const bool goes_on =
        results_.take(GST_CLOCK_TIME_IS_VALID(time) ? static_cast<int64_t>(time) : sync::kNoTime,
                      limits_, &found_);
    if (results_.late() > late && !std::exchange(is_stall_checked_, true)) warn_of_stall();
    return goes_on;
  }

  Pad results_;
  // Used by the streaming thread of the pictures.
  typename Pad::Limits limits_;
  typename Pad::Results found_;  // for the current picture

 private:
  // Warns where the results of a picture cannot arrive, because it blocks the thread that pushes
  // them.
  void warn_of_stall() {
    const auto status =
        can_wait(this->element(), GST_BASE_TRANSFORM_SINK_PAD(this->self()), results_pad_);
    if (!status) post_warning(this->element(), status.error());
  }
  void add_wait(GstQuery* query) const {
    gboolean live = FALSE;
    GstClockTime min = 0, max = 0;
    gst_query_parse_latency(query, &live, &min, &max);
    const uint64_t wait = latency_;
    if (!live || wait == 0) return;
    if (GST_CLOCK_TIME_IS_VALID(max)) max += wait;
    gst_query_set_latency(query, live, min + wait, max);
  }

  GstPad* results_pad_ = nullptr;     // owned by the element
  bool same_time_ = false;            // changes only while not streaming
  bool is_stall_checked_ = false;     // pictures' streaming thread
  std::atomic<uint64_t> latency_{0};  // how long pictures wait for results, nanoseconds
};

}  // namespace weir::gst
