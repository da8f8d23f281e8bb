// CollectorPads: events and queries of an element with many inputs.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>

#include "gstcpp/buffer/tensor_caps.hpp"
#include "gstcpp/element/described_caps.hpp"
#include "gstcpp/element/element.hpp"
#include "gstcpp/element/model_event.hpp"
#include "gstcpp/pads/collector_pads.hpp"

namespace weir::gst {
namespace {

bool has(GstEvent* event, GstEventTypeFlags flag) {
  return (gst_event_type_get_flags(GST_EVENT_TYPE(event)) & flag) != 0;
}
bool is_serialized(GstQuery* query) {
  return (gst_query_type_get_flags(GST_QUERY_TYPE(query)) & GST_QUERY_TYPE_SERIALIZED) != 0;
}

}  // namespace

GstFlowReturn CollectorPads::on_chain(GstPad* pad, GstObject* parent, GstBuffer* buffer) {
  auto held = Ref<GstBuffer>::adopt(buffer);
  auto* data = static_cast<Pad*>(gst_pad_get_element_private(pad));
  if (!data) return GST_FLOW_FLUSHING;
  return guarded<GstFlowReturn>(GST_ELEMENT_CAST(parent),
                                [&] { return data->owner->chain(*data, std::move(held)); });
}

gboolean CollectorPads::on_sink_event(GstPad* pad, GstObject* parent, GstEvent* event) {
  auto held = Ref<GstEvent>::adopt(event);
  auto* data = static_cast<Pad*>(gst_pad_get_element_private(pad));
  if (!data) return FALSE;
  CapsTrial trial(GST_ELEMENT_CAST(parent), event);
  return trial.ended(guarded<gboolean>(
      GST_ELEMENT_CAST(parent), [&] { return data->owner->sink_event(*data, std::move(held)); }));
}

// Called before the stream lock is taken, so that a thread waiting in chain() returns.
gboolean CollectorPads::on_activate(GstPad* pad, GstObject*, GstPadMode mode, gboolean active) {
  if (mode != GST_PAD_MODE_PUSH) return FALSE;
  if (const auto* data = static_cast<Pad*>(gst_pad_get_element_private(pad)))
    data->owner->collector_.set_active(data->queue, active);
  return TRUE;
}

gboolean CollectorPads::sink_event(Pad& pad, Ref<GstEvent> event) {
  if (has(event.get(), GST_EVENT_TYPE_SERIALIZED)) pad.fed_by = g_thread_self();
  switch (GST_EVENT_TYPE(event.get())) {
    case GST_EVENT_STREAM_START:
      collector_.begin(pad.queue);
      return TRUE;
    case GST_EVENT_CAPS:
      return caps(pad, event.get());
    case GST_EVENT_SEGMENT:
      gst_event_copy_segment(event.get(), &pad.segment);
      return TRUE;
    case GST_EVENT_GAP: {
      GstClockTime start = 0, duration = 0;
      gst_event_parse_gap(event.get(), &start, &duration);
      if (!GST_CLOCK_TIME_IS_VALID(start)) return TRUE;
      if (!GST_CLOCK_TIME_IS_VALID(duration) || duration > G_MAXUINT64 / 2) duration = 0;
      collector_.gap(pad.queue, start + duration);
      return TRUE;
    }
    case GST_EVENT_EOS:
      collector_.end(pad.queue);
      return TRUE;
    case GST_EVENT_FLUSH_START:
      return !collector_.flush_start(pad.queue) || send_flush(std::move(event));
    case GST_EVENT_FLUSH_STOP:
      pad.fed_by = nullptr;
      pad.last_time.reset();
      gst_segment_init(&pad.segment, GST_FORMAT_UNDEFINED);
      return !collector_.flush_stop(pad.queue) || send_flush(std::move(event));
    default:
      if (is_model_event(event.get())) return TRUE;  // the output has other tensors
      return pass_on(pad, std::move(event));
  }
}

bool CollectorPads::send_flush(Ref<GstEvent> event) {
  if (GST_EVENT_TYPE(event.get()) == GST_EVENT_FLUSH_STOP) segment_due_ = true;
  const bool sent = gst_pad_push_event(source_, event.release());
  collector_.flush_sent();
  return sent;
}

gboolean CollectorPads::caps(Pad& pad, GstEvent* event) {
  GstCaps* caps = nullptr;
  gst_event_parse_caps(event, &caps);
  auto spec = fixed_spec_from_caps(caps);
  if (!spec) {
    post_error(element_, spec.error());
    return FALSE;
  }
  spec->roles = roles_from_caps(caps);
  pad.spec = std::make_shared<const FrameSpec>(*std::move(spec));
  return TRUE;
}

gboolean CollectorPads::pass_on(Pad& pad, Ref<GstEvent> event) {
  if (has(event.get(), GST_EVENT_TYPE_STICKY)) {
    std::lock_guard lock(pads_mutex_);
    if (!begun_) {
      pending_.push(std::move(event));
      return TRUE;
    }
  }
  if (!has(event.get(), GST_EVENT_TYPE_SERIALIZED))
    return gst_pad_event_default(pad.pad, GST_OBJECT_CAST(element_), event.release());
  gboolean taken = FALSE;
  collector_.use_output(pad.queue, [&] {
    taken = gst_pad_event_default(pad.pad, GST_OBJECT_CAST(element_), event.release());
  });
  return taken;
}

// A serialized query must not pass the buffer that is being pushed downstream.
gboolean CollectorPads::on_sink_query(GstPad* pad, GstObject* parent, GstQuery* query) {
  auto* data = static_cast<Pad*>(gst_pad_get_element_private(pad));
  if (!data || !is_serialized(query)) return query_with_static_filter(pad, parent, query);
  gboolean handled = FALSE;
  data->owner->collector_.use_output(data->queue,
                                     [&] { handled = gst_pad_query_default(pad, parent, query); });
  return handled;
}

void CollectorPads::begin_stream() {
  if (begun_) return;
  const UniqueText id{g_strdup_printf("%s-%08x", GST_ELEMENT_NAME(element_), g_random_int())};
  GstEvent* start = gst_event_new_stream_start(id.get());
  gst_event_set_group_id(start, gst_util_group_id_next());
  gst_pad_push_event(source_, start);
  std::lock_guard lock(pads_mutex_);
  begun_ = true;
}

void CollectorPads::begin_segment(uint64_t start, uint64_t time,
                                  std::optional<uint64_t> running_time) {
  GstSegment segment;
  gst_segment_init(&segment, GST_FORMAT_TIME);
  segment.start = segment.position = segment.time = start;
  const uint64_t ahead = time - std::min(start, time);
  if (running_time) segment.base = *running_time - std::min(*running_time, ahead);
  gst_pad_push_event(source_, gst_event_new_segment(&segment));
  EarlyEvents pending;
  {
    std::lock_guard lock(pads_mutex_);
    std::swap(pending, pending_);
  }
  pending.send(source_);
}

gboolean CollectorPads::on_source_event(GstPad* pad, GstObject* parent, GstEvent* event) {
  if (GST_EVENT_TYPE(event) == GST_EVENT_SEEK) {
    gst_event_unref(event);
    return FALSE;
  }
  return gst_pad_event_default(pad, parent, event);
}

gboolean CollectorPads::on_source_query(GstPad* pad, GstObject* parent, GstQuery* query) {
  auto* owner = static_cast<CollectorPads*>(gst_pad_get_element_private(pad));
  if (GST_QUERY_TYPE(query) != GST_QUERY_LATENCY) return gst_pad_query_default(pad, parent, query);
  return guarded<gboolean>(GST_ELEMENT_CAST(parent), [&] { return owner->latency(query); });
}

// The highest minimum latency of the live inputs plus max-wait.
gboolean CollectorPads::latency(GstQuery* query) {
  // A loop of links would recurse forever.
  static thread_local std::vector<const CollectorPads*> querying;
  if (std::find(querying.begin(), querying.end(), this) != querying.end()) return FALSE;
  querying.push_back(this);
  bool live = false, handled = true;
  GstClockTime min = 0, max = GST_CLOCK_TIME_NONE;
  for (const auto& pad : sink_pads()) {
    const Unique<GstQuery, gst_query_unref> one(gst_query_new_latency());
    if (!gst_pad_is_linked(pad.get())) continue;
    if (!gst_pad_peer_query(pad.get(), one.get())) {
      handled = false;
      continue;
    }
    gboolean is_live = FALSE;
    GstClockTime low = 0, high = 0;
    gst_query_parse_latency(one.get(), &is_live, &low, &high);
    if (!is_live) continue;
    live = true;
    min = std::max(min, low);
    if (GST_CLOCK_TIME_IS_VALID(high))
      max = GST_CLOCK_TIME_IS_VALID(max) ? std::min(max, high) : high;
  }
  querying.pop_back();
  if (live) {
    min += max_wait_;
    if (GST_CLOCK_TIME_IS_VALID(max)) max += max_wait_;
  }
  gst_query_set_latency(query, live, min, max);
  return handled || live;
}

}  // namespace weir::gst
