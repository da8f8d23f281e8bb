// CountedTransform: a GstBaseTransform that also counts frames that the base class drops before
// transform(). Impl's transform() or transform_ip() finishes each frame with one of
// ledger_.consumed_and_pushed(), ledger_.dropped(reason) or failed(error).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "core/ledger/ledger.hpp"
#include "gstcpp/element/base_classes.hpp"
#include "gstcpp/element/described_caps.hpp"

namespace weir::gst {

// Why a frame was lost when GstBaseTransform's submit_input_buffer() returned `flow`.
inline DropReason to_drop_reason(GstFlowReturn flow) {
  switch (static_cast<int>(flow)) {
    case GST_BASE_TRANSFORM_FLOW_DROPPED:
      return DropReason::Qos;
    case GST_FLOW_EOS:
      return DropReason::Eos;
    case GST_FLOW_FLUSHING:
      return DropReason::Flush;
    default:
      return DropReason::Error;
  }
}

template <class Impl>
class CountedTransform : public Element<Impl, BaseTransform> {
 public:
  GstFlowReturn submit_input_buffer(gboolean discont, GstBuffer* buffer) {
    ledger_.received();
    const auto flow = this->parent_class()->submit_input_buffer(this->self(), discont, buffer);
    if (flow != GST_FLOW_OK) ledger_.dropped(to_drop_reason(flow));
    return flow;
  }

  gboolean query(GstPadDirection direction, GstQuery* query) {
    return with_static_filter(query, [&](GstQuery* described) {
      return this->parent_class()->query(this->self(), direction, described);
    });
  }

  Ledger ledger_;

 protected:
  // Reports that the current frame is lost to `error`.
  GstFlowReturn failed(const Error& error) {
    ledger_.dropped(DropReason::Error);
    post_error(this->element(), error);
    return GST_FLOW_ERROR;
  }

  // For transform_caps() of an element that takes whatever its sink pad's template says, and whose
  // output follows from its input: `output` returns the output caps for the caps in question.
  template <class Output>
  GstCaps* caps_of_other_pad(GstPadDirection direction, GstCaps* filter, const Output& output) {
    GstPad* const sink = GST_BASE_TRANSFORM_SINK_PAD(this->self());
    const Ref<GstCaps> caps = direction == GST_PAD_SRC
                                  ? Ref<GstCaps>::adopt(gst_pad_get_pad_template_caps(sink))
                                  : output();
    if (!filter) return gst_caps_ref(caps.get());
    return gst_caps_intersect_full(filter, caps.get(), GST_CAPS_INTERSECT_FIRST);
  }

  // Copies flags, times and metas of `in` by the rules of the base class.
  void copy_metadata(GstBuffer* in, GstBuffer* out) {
    if (!this->parent_class()->copy_metadata(this->self(), in, out))
      GST_CAT_WARNING_OBJECT(this->category(), this->self(),
                             "metadata of a buffer could not be copied");
  }
};

}  // namespace weir::gst
