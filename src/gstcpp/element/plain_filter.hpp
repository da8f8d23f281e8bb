// PlainFilter: an element with one sink and one source pad that sends its own caps and may hold
// frames. Impl has
//   Status set_caps(GstCaps*)            handles the sink pad's caps
//   GstFlowReturn chain(Ref<GstBuffer>)  a received frame; finish it in ledger_ or hold it
//   void drain(DropReason)               called at EOS, at a flush and when the stream stops
//   void reset()                         when the stream stops: clears caps and stream state
//   bool sink_event(GstEvent*)           optional: true when it took over the event
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/ledger/ledger.hpp"
#include "gstcpp/element/base_classes.hpp"
#include "gstcpp/element/model_event.hpp"
#include "gstcpp/element/ref.hpp"

namespace weir::gst {

template <class Impl>
class PlainFilter : public Element<Impl, PlainElement> {
  using E = Element<Impl, PlainElement>;

 public:
  void constructed() {
    sink_ = this->add_pad("sink");
    source_ = this->add_pad("src");
    gst_pad_set_chain_function(sink_, (E::template chain<&PlainFilter::on_buffer>));
    gst_pad_set_event_function(sink_, (E::template pad_event<&PlainFilter::on_event>));
    if constexpr (requires { &Impl::on_query; }) {
      gst_pad_set_query_function(sink_, (E::template pad_query<&Impl::on_query>));
      gst_pad_set_query_function(source_, (E::template pad_query<&Impl::on_query>));
    }
  }

  GstStateChangeReturn change_state(GstStateChange change) {
    if (change == GST_STATE_CHANGE_READY_TO_PAUSED) ledger_.reset();
    const auto result = this->parent_class()->change_state(this->element(), change);
    if (change == GST_STATE_CHANGE_PAUSED_TO_READY) {
      impl()->drain(DropReason::Flush);
      impl()->reset();
    }
    return result;
  }

  GstFlowReturn on_buffer(GstBuffer* buffer) {
    ledger_.received();
    return impl()->chain(Ref<GstBuffer>::adopt(buffer));
  }

  gboolean on_event(GstPad* pad, GstEvent* event) {
    if (GST_EVENT_TYPE(event) == GST_EVENT_CAPS) {
      const auto owned = Ref<GstEvent>::adopt(event);
      GstCaps* caps = nullptr;
      gst_event_parse_caps(event, &caps);
      const Status status = impl()->set_caps(caps);
      if (!status) post_error(this->element(), status.error());
      return status.has_value();
    }
    if (is_model_event(event)) {  // the output has other tensors
      gst_event_unref(event);
      return TRUE;
    }
    if (GST_EVENT_TYPE(event) == GST_EVENT_EOS) impl()->drain(DropReason::Eos);
    if (GST_EVENT_TYPE(event) == GST_EVENT_FLUSH_STOP) impl()->drain(DropReason::Flush);
    if constexpr (requires { impl()->sink_event(event); })
      if (impl()->sink_event(event)) return TRUE;
    return gst_pad_event_default(pad, GST_OBJECT_CAST(this->self()), event);
  }

  Ledger ledger_;

 protected:
  // Reports that a received frame is lost to `error`.
  GstFlowReturn failed(const Error& error) {
    ledger_.dropped(DropReason::Error);
    post_error(this->element(), error);
    return error.code == Code::NOT_NEGOTIATED ? GST_FLOW_NOT_NEGOTIATED : GST_FLOW_ERROR;
  }

  GstPad* sink_ = nullptr;    // owned by the element
  GstPad* source_ = nullptr;  // owned by the element

 private:
  Impl* impl() { return static_cast<Impl*>(this); }
};

}  // namespace weir::gst
