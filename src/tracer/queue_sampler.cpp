// Levels and limits of a queue, read from its properties.
#include "tracer/queue_sampler.hpp"

#include <algorithm>
#include <string_view>

#include "gstcpp/ref.hpp"

namespace weir::tracer {
namespace {

// Thousandths of a limit; 0 is no limit.
uint64_t share(uint64_t level, uint64_t limit) {
  if (limit == 0) return 0;
  return static_cast<uint64_t>(
      std::min(static_cast<double>(level) * 1000 / static_cast<double>(limit), 1e5));
}

bool leaks(GstElement* queue) {
  if (!g_object_class_find_property(G_OBJECT_GET_CLASS(queue), "leaky")) return false;
  gint leaky = 0;  // an enumeration, 0 is no
  g_object_get(queue, "leaky", &leaky, nullptr);
  return leaky != 0;
}

}  // namespace

WatchedQueue::WatchedQueue(GstElement* queue) : address_(queue) {
  g_weak_ref_init(&queue_, queue);
}

WatchedQueue::~WatchedQueue() {
  g_weak_ref_clear(&queue_);
}

bool WatchedQueue::can_be_watched(GstElement* element) {
  GstElementFactory* factory = gst_element_get_factory(element);
  if (!factory) return false;
  const std::string_view name = gst_plugin_feature_get_name(GST_PLUGIN_FEATURE(factory));
  return name == "queue" || name == "queue2";
}

void WatchedQueue::take(int64_t time, trace::Recorder* recorder) {
  const auto queue = gst::Ref<GstElement>::adopt(static_cast<GstElement*>(g_weak_ref_get(&queue_)));
  if (!queue) return;
  guint frames = 0, bytes = 0, most_frames = 0, most_bytes = 0;
  guint64 time_inside = 0, most_time = 0;
  g_object_get(queue.get(), "current-level-buffers", &frames, "current-level-bytes", &bytes,
               "current-level-time", &time_inside, "max-size-buffers", &most_frames,
               "max-size-bytes", &most_bytes, "max-size-time", &most_time, nullptr);
  period_.store(leaks(queue.get()) ? 0 : kPeriod, std::memory_order_relaxed);
  trace::Record record;
  record.time = time;
  record.object = address_;
  record.value = frames;
  record.kind = static_cast<unsigned>(trace::Kind::Level) & 15U;
  record.frames = std::max({share(frames, most_frames), share(bytes, most_bytes),
                            share(time_inside, most_time)}) &
                  trace::kMostFrames;
  record.bytes = bytes;
  recorder->log().append(record);
}

}  // namespace weir::tracer
