// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tracer/queue_sampler.hpp"

#include <algorithm>
#include <string_view>

#include "gstcpp/element/ref.hpp"

namespace weir::tracer {
namespace {

// In thousandths of the limit; 0 means no limit.
uint64_t share(uint64_t level, uint64_t limit) {
  if (limit == 0) return 0;
  return static_cast<uint64_t>(
      std::min(static_cast<double>(level) * 1000 / static_cast<double>(limit), 1e5));
}

bool leaks(GstElement* queue) {
  if (!g_object_class_find_property(G_OBJECT_GET_CLASS(queue), "leaky")) return false;
  gint leaky = 0;  // an enumeration; 0: not leaky
  g_object_get(queue, "leaky", &leaky, nullptr);
  return leaky != 0;
}

std::string_view get_factory(GstElement* element) {
  GstElementFactory* factory = gst_element_get_factory(element);
  return factory ? gst_plugin_feature_get_name(GST_PLUGIN_FEATURE(factory)) : "";
}

struct Limits {
  guint frames = 0, bytes = 0;
  guint64 time = 0;
};
Limits get_limits(GstElement* queue) {
  Limits out;
  g_object_get(queue, "max-size-buffers", &out.frames, "max-size-bytes", &out.bytes,
               "max-size-time", &out.time, nullptr);
  return out;
}

struct Level {
  uint64_t frames = 0, bytes = 0, fullest = 0;

  // Adds a queue, or the pad of one queue of a multiqueue.
  void add(GObject* object, const Limits& limits) {
    guint frames_now = 0, bytes_now = 0;
    guint64 time_now = 0;
    g_object_get(object, "current-level-buffers", &frames_now, "current-level-bytes", &bytes_now,
                 "current-level-time", &time_now, nullptr);
    frames += frames_now;
    bytes += bytes_now;
    fullest = std::max({fullest, share(frames_now, limits.frames), share(bytes_now, limits.bytes),
                        share(time_now, limits.time)});
  }
};

std::vector<gst::Ref<GstPad>> get_sinks(GstElement* element) {
  std::vector<gst::Ref<GstPad>> out;
  GST_OBJECT_LOCK(element);
  for (const GList* pad = element->sinkpads; pad; pad = pad->next)
    out.push_back(gst::Ref<GstPad>::share(GST_PAD(pad->data)));
  GST_OBJECT_UNLOCK(element);
  return out;
}

}  // namespace

WatchedQueue::WatchedQueue(GstElement* queue)
    : address_(queue), several_(get_factory(queue) == "multiqueue") {
  g_weak_ref_init(&queue_, queue);
}

WatchedQueue::~WatchedQueue() {
  g_weak_ref_clear(&queue_);
}

bool WatchedQueue::can_be_watched(GstElement* element) {
  const std::string_view name = get_factory(element);
  return name == "queue" || name == "queue2" || name == "multiqueue";
}

void WatchedQueue::take(int64_t time, trace::Recorder* recorder) {
  const auto queue = gst::Ref<GstElement>::adopt(static_cast<GstElement*>(g_weak_ref_get(&queue_)));
  if (!queue) return;
  const Limits limits = get_limits(queue.get());
  Level level;
  if (several_)
    for (const auto& pad : get_sinks(queue.get())) level.add(G_OBJECT(pad.get()), limits);
  else
    level.add(G_OBJECT(queue.get()), limits);
  period_.store(leaks(queue.get()) ? 0 : kPeriod, std::memory_order_relaxed);
  trace::Record record;
  record.time = time;
  record.object = address_;
  record.value = static_cast<decltype(record.value)>(level.frames);
  record.kind = static_cast<unsigned>(trace::Kind::Level) & 15U;
  record.frames = level.fullest & trace::kMaxFrames;
  record.bytes = level.bytes & trace::kMaxBytes;
  recorder->log().append(record);
}

}  // namespace weir::tracer
