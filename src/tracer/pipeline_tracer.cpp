// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tracer/pipeline_tracer.hpp"

#include <gst/base/gstbasesink.h>
#include <gst/base/gstbasesrc.h>
#include <gst/gst.h>

#include <array>
#include <ctime>

#include "core/trace/graph.hpp"
#include "gstcpp/element/ref.hpp"
#include "tracer/queue_sampler.hpp"

namespace weir::tracer {
namespace {

bool is_set(GstElement* element, const char* property) {
  GParamSpec* spec = g_object_class_find_property(G_OBJECT_GET_CLASS(element), property);
  if (!spec || spec->value_type != G_TYPE_BOOLEAN || !(spec->flags & G_PARAM_READABLE))
    return false;
  gboolean value = FALSE;
  g_object_get(element, property, &value, nullptr);
  return value != FALSE;
}

bool has_several_inputs(GstElement* element) {
  GST_OBJECT_LOCK(element);
  const bool several = element->numsinkpads > 1;
  GST_OBJECT_UNLOCK(element);
  return several;
}

// Reads properties, so no lock may be held. Never for null.
trace::Waits get_waits(GstElement* element) {
  if (!element || GST_IS_BIN(element)) return trace::Waits::Never;
  if (WatchedQueue::can_be_watched(element)) return trace::Waits::Room;
  if (GST_IS_BASE_SRC(element))
    return gst_base_src_is_live(GST_BASE_SRC(element)) ? trace::Waits::Device : trace::Waits::Never;
  if (is_set(element, "sync")) return trace::Waits::Clock;
  if (GST_IS_BASE_SINK(element)) return trace::Waits::Start;
  return has_several_inputs(element) ? trace::Waits::Inputs : trace::Waits::Never;
}

}  // namespace

using trace::Kind;
using trace::Waits;

namespace {

thread_local unsigned open_pushes = 0;  // of the calling thread, one in another

int64_t thread_time() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<int64_t>(now.tv_sec) * 1'000'000'000 + now.tv_nsec;
}

gst::Ref<GstElement> get_element(GstPad* pad) {
  return gst::Ref<GstElement>::adopt(gst_pad_get_parent_element(pad));
}

bool measures_pushes(Waits waits) {
  return waits == Waits::Clock || waits == Waits::Inputs;
}

// A source whose time between two pushes is all work.
bool makes_frames(GstElement* element, Waits waits) {
  return element && GST_IS_BASE_SRC(element) && waits != Waits::Device;
}

int64_t time_stamp(GstBuffer* buffer) {
  const GstClockTime time = buffer ? GST_BUFFER_PTS(buffer) : GST_CLOCK_TIME_NONE;
  return time <= static_cast<GstClockTime>(trace::kForEver) ? static_cast<int64_t>(time)
                                                            : trace::kNoTime;
}

std::string get_name(gpointer object) {
  const gst::UniqueText name(gst_object_get_name(GST_OBJECT(object)));
  return name ? name.get() : "";
}

}  // namespace

// Unique across tracers, so that no thread reuses what it cached for another one.
uint64_t PipelineTracer::next_generation() {
  static std::atomic<uint64_t> last = 0;
  return ++last;
}

void PipelineTracer::forget_remembered() {
  generation_.store(next_generation(), std::memory_order_release);
}

void PipelineTracer::append(Kind kind, int64_t time, const void* object, int64_t value,
                            uint64_t frames, uint64_t bytes) {
  trace::Record record;
  record.time = time;
  record.object = object;
  record.value = value;
  record.kind = static_cast<unsigned>(kind) & 15U;
  record.frames = std::min(frames, trace::kMaxFrames) & trace::kMaxFrames;
  record.bytes = std::min(bytes, trace::kMaxBytes) & trace::kMaxBytes;
  recorder_.log().append(record);
}

void PipelineTracer::append_named(Kind kind, int64_t time, const void* object, const char* name) {
  trace::Record record;
  record.time = time;
  record.object = object;
  record.name = name;
  record.kind = static_cast<unsigned>(kind) & 15U;
  recorder_.log().append(record);
}

PipelineTracer::Remembered& PipelineTracer::remembered(GstPad* pad) {
  static thread_local std::array<Remembered, 64> table;
  Remembered& place = table[(reinterpret_cast<uintptr_t>(pad) >> 5) % table.size()];
  const uint64_t generation = generation_.load(std::memory_order_acquire);
  if (place.pad != pad || place.generation != generation) place = look_up(pad, generation);
  return place;
}

PipelineTracer::Remembered PipelineTracer::look_up(GstPad* pad, uint64_t generation) {
  const auto own = get_element(pad);
  const auto peer_pad = gst::Ref<GstPad>::adopt(gst_pad_get_peer(pad));
  const auto peer = peer_pad ? get_element(peer_pad.get()) : gst::Ref<GstElement>();
  const Waits own_waits = get_waits(own.get()), peer_waits = get_waits(peer.get());
  std::lock_guard lock(mutex_);
  const auto find_queue = [&](size_t id) -> WatchedQueue* {
    const auto found = queues_.find(graph_.owner(id));
    return found == queues_.end() ? nullptr : found->second.get();
  };
  graph_.set_waits(own.get(), own_waits);
  graph_.set_waits(peer.get(), peer_waits);
  const size_t id = graph_.pad_at(pad, trace::kForEver);
  Remembered out{pad, generation, find_queue(id), find_queue(graph_.peer_at(id, trace::kForEver))};
  out.is_timed = measures_pushes(own_waits) || measures_pushes(peer_waits);
  out.is_timed_outermost = own_waits != Waits::Room && !makes_frames(own.get(), own_waits);
  return out;
}

void PipelineTracer::begin_push(int64_t time, GstPad* pad, int64_t time_stamp, uint64_t frames,
                                uint64_t bytes) {
  const Remembered& facts = remembered(pad);
  if (facts.own) facts.own->sample(time, &recorder_);
  const bool is_outermost = open_pushes++ == 0;
  if (facts.is_timed || facts.is_timed_once || (is_outermost && facts.is_timed_outermost))
    append(Kind::ThreadTime, time, nullptr, thread_time());
  append(Kind::PushBegin, time, pad, time_stamp, frames, bytes);
}

void PipelineTracer::push_begins(int64_t time, GstPad* pad, GstBuffer* buffer) {
  begin_push(time, pad, time_stamp(buffer), 1, gst_buffer_get_size(buffer));
}

void PipelineTracer::push_begins(int64_t time, GstPad* pad, GstBufferList* list) {
  const guint frames = gst_buffer_list_length(list);
  GstBuffer* first = frames > 0 ? gst_buffer_list_get(list, 0) : nullptr;
  begin_push(time, pad, time_stamp(first), frames, gst_buffer_list_calculate_size(list));
}

void PipelineTracer::push_ends(int64_t time, GstPad* pad, GstFlowReturn result) {
  Remembered& facts = remembered(pad);
  const bool is_outermost = open_pushes > 0 && --open_pushes == 0;
  if (facts.is_timed || facts.is_timed_once || (is_outermost && facts.is_timed_outermost))
    append(Kind::ThreadTime, time, nullptr, thread_time());
  facts.is_timed_once = false;
  append(Kind::PushEnd, time, pad, result < 0 ? result : 0);
  if (facts.peer) facts.peer->sample(time, &recorder_);
}

void PipelineTracer::pull_begins(int64_t time, GstPad* pad) {
  append(Kind::PullBegin, time, pad, trace::kNoTime);
}

void PipelineTracer::pull_ends(int64_t time, GstPad* pad, GstBuffer* buffer, GstFlowReturn result) {
  const bool good = result >= 0 && buffer;
  append(Kind::PullEnd, time, pad, good ? 0 : -1, good ? 1 : 0,
         good ? gst_buffer_get_size(buffer) : 0);
}

void PipelineTracer::event_begins(int64_t time, GstPad* pad, GstEvent* event) {
  if (GST_EVENT_TYPE(event) == GST_EVENT_CAPS) {
    GstCaps* caps = nullptr;
    gst_event_parse_caps(event, &caps);
    const gst::UniqueText text(gst_caps_to_string(caps));
    std::lock_guard lock(mutex_);
    if (text) graph_.set_caps(pad, text.get());
  }
  append_named(Kind::EventBegin, time, pad, GST_EVENT_TYPE_NAME(event));
}

void PipelineTracer::event_ends(int64_t time, GstPad* pad, bool good) {
  append(Kind::EventEnd, time, pad, good ? 0 : -1);
}

void PipelineTracer::state_begins(int64_t time, GstElement* element, GstStateChange change) {
  append_named(Kind::StateBegin, time, element, gst_state_change_get_name(change));
}

void PipelineTracer::state_ends(int64_t time, GstElement* element, bool good) {
  append(Kind::StateEnd, time, element, good ? 0 : -1);
}

void PipelineTracer::name_element(int64_t time, GstElement* element) {
  const auto parent = gst::Ref<GstObject>::adopt(gst_object_get_parent(GST_OBJECT(element)));
  GstElementFactory* factory = gst_element_get_factory(element);
  graph_.name_element(element, parent.get(), get_name(element),
                      factory ? gst_plugin_feature_get_name(GST_PLUGIN_FEATURE(factory)) : "",
                      GST_IS_BIN(element), time);
}

// Called when the element is created and when it is added to a bin; its name is final then.
void PipelineTracer::element_is_new(int64_t time, GstElement* element) {
  std::lock_guard lock(mutex_);
  name_element(time, element);
  graph_.added(element);
  auto& queue = queues_[graph_.see_element(element, time)];
  if (!queue && WatchedQueue::can_be_watched(element)) {
    queue = std::make_unique<WatchedQueue>(element);
    forget_remembered();
  }
}

void PipelineTracer::see_pad(int64_t time, GstPad* pad, GstElement* element) {
  graph_.see_pad(pad, element, get_name(pad), GST_PAD_IS_SRC(pad), time);
  if (!GST_IS_GHOST_PAD(pad)) return;
  const auto inner = gst::Ref<GstProxyPad>::adopt(gst_proxy_pad_get_internal(GST_PROXY_PAD(pad)));
  if (!inner) return;
  graph_.see_pad(inner.get(), nullptr, get_name(inner.get()), GST_PAD_IS_SRC(inner.get()), time);
  graph_.join_halves(pad, inner.get());
}

void PipelineTracer::pad_is_added(int64_t time, GstElement* element, GstPad* pad) {
  std::lock_guard lock(mutex_);
  see_pad(time, pad, element);
  forget_remembered();
}

// Ghost pads are linked to the pad inside before they are added to their bin.
void PipelineTracer::pads_are_linked(int64_t time, GstPad* source, GstPad* sink) {
  std::lock_guard lock(mutex_);
  for (GstPad* pad : {source, sink}) {
    const auto parent = gst::Ref<GstObject>::adopt(gst_object_get_parent(GST_OBJECT(pad)));
    if (parent && GST_IS_GHOST_PAD(parent.get()))
      see_pad(time, GST_PAD(parent.get()), nullptr);
    else
      see_pad(time, pad,
              parent && GST_IS_ELEMENT(parent.get()) ? GST_ELEMENT(parent.get()) : nullptr);
  }
  graph_.link(source, sink, time);
  forget_remembered();
}

void PipelineTracer::pads_are_unlinked(int64_t time, GstPad* source, GstPad* sink) {
  std::lock_guard lock(mutex_);
  graph_.unlink(source, sink, time);
  forget_remembered();
}

void PipelineTracer::element_is_removed(int64_t, GstElement* element) {
  std::lock_guard lock(mutex_);
  graph_.removed(element);
}

void PipelineTracer::object_is_destroyed(int64_t time, const void* object) {
  std::lock_guard lock(mutex_);
  if (graph_.destroyed(object, time)) forget_remembered();
}

trace::Trace PipelineTracer::trace() const {
  std::lock_guard lock(mutex_);
  return {graph_, recorder_.threads()};
}

}  // namespace weir::tracer
