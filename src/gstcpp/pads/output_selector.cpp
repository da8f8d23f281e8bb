// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/pads/output_selector.hpp"

namespace weir::gst {
namespace {

// The selector sends the segment itself.
gboolean send_on(GstPad*, GstEvent** event, gpointer pad) {
  if (GST_EVENT_TYPE(*event) == GST_EVENT_STREAM_START || GST_EVENT_TYPE(*event) == GST_EVENT_CAPS)
    gst_pad_push_event(GST_PAD(pad), gst_event_ref(*event));
  return TRUE;
}

bool is_active(GstPad* pad, GstElement* selector) {
  GstPad* active = nullptr;
  g_object_get(selector, "active-pad", &active, nullptr);
  return Ref<GstPad>::adopt(active).get() == pad;
}

// Runs on the streaming thread, before the next serialized event or buffer.
GstPadProbeReturn send_sticky_events(GstPad* feeding, GstPadProbeInfo* info, gpointer pad) {
  if (GST_PAD_PROBE_INFO_TYPE(info) & GST_PAD_PROBE_TYPE_EVENT_DOWNSTREAM) {
    const GstEventType type = GST_EVENT_TYPE(GST_PAD_PROBE_INFO_EVENT(info));
    const bool serialized = gst_event_type_get_flags(type) & GST_EVENT_TYPE_SERIALIZED;
    if (!serialized || type == GST_EVENT_STREAM_START) return GST_PAD_PROBE_OK;
  }
  const auto selector = Ref<GstElement>::adopt(gst_pad_get_parent_element(GST_PAD(pad)));
  if (selector && is_active(GST_PAD(pad), selector.get()))
    gst_pad_sticky_events_foreach(feeding, send_on, pad);
  return GST_PAD_PROBE_REMOVE;
}

GstPadProbeReturn make_active(GstPad* feeding, GstPadProbeInfo*, gpointer pad) {
  const auto selector = Ref<GstElement>::adopt(gst_pad_get_parent_element(GST_PAD(pad)));
  if (!selector) return GST_PAD_PROBE_REMOVE;  // the pad was released meanwhile
  g_object_set(selector.get(), "active-pad", pad, nullptr);
  gst_pad_add_probe(feeding, GST_PAD_PROBE_TYPE_DATA_DOWNSTREAM, send_sticky_events,
                    gst_object_ref(pad), gst_object_unref);
  return GST_PAD_PROBE_REMOVE;
}

}  // namespace

void switch_output(const Ref<GstPad>& pad) {
  const auto selector = Ref<GstElement>::adopt(gst_pad_get_parent_element(pad.get()));
  if (!selector) return;
  const auto sink = Ref<GstPad>::adopt(gst_element_get_static_pad(selector.get(), "sink"));
  const auto feeding = Ref<GstPad>::adopt(gst_pad_get_peer(sink.get()));
  if (feeding)
    gst_pad_add_probe(feeding.get(), GST_PAD_PROBE_TYPE_IDLE, make_active,
                      gst_object_ref(pad.get()), gst_object_unref);
  else
    g_object_set(selector.get(), "active-pad", pad.get(), nullptr);
}

}  // namespace weir::gst
