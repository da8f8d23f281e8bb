// ManyInputs: an element of request pads between bare pads; each input is pushed by its own thread.
#pragma once
#include <gst/gst.h>
#include <gtest/gtest.h>

#include <future>
#include <mutex>
#include <string>
#include <vector>

#include "becomes.hpp"
#include "gstcpp/ref.hpp"

namespace weir::testing {

using gst::Ref;
using Bytes = std::vector<uint8_t>;

inline Ref<GstBuffer> buffer_of(const std::vector<Bytes>& memories, GstClockTime pts) {
  auto buffer = Ref<GstBuffer>::adopt(gst_buffer_new());
  for (const Bytes& bytes : memories) {
    GstMemory* memory = gst_allocator_alloc(nullptr, bytes.size(), nullptr);
    const gst::MappedMemory map(memory, GST_MAP_WRITE);
    std::copy(bytes.begin(), bytes.end(), reinterpret_cast<uint8_t*>(map.bytes().data()));
    gst_buffer_append_memory(buffer.get(), memory);
  }
  GST_BUFFER_PTS(buffer.get()) = pts;
  return buffer;
}

inline std::vector<Bytes> memories_of(GstBuffer* buffer) {
  std::vector<Bytes> out;
  for (guint i = 0; i < gst_buffer_n_memory(buffer); ++i) {
    const gst::MappedMemory map(gst_buffer_peek_memory(buffer, i), GST_MAP_READ);
    const auto* data = reinterpret_cast<const uint8_t*>(map.bytes().data());
    out.emplace_back(data, data + map.bytes().size());
  }
  return out;
}

class ManyInputs {
 public:
  explicit ManyInputs(const std::string& launch, const char* sink_caps = "ANY") {
    element_ = Ref<GstElement>::adopt(GST_ELEMENT(gst_object_ref_sink(
        gst_parse_launch_full(launch.c_str(), nullptr, GST_PARSE_FLAG_FATAL_ERRORS, nullptr))));
    bus_ = Ref<GstBus>::adopt(gst_bus_new());
    gst_element_set_bus(element_.get(), bus_.get());
    const auto caps = Ref<GstCaps>::adopt(gst_caps_from_string(sink_caps));
    auto* pad_template = gst_pad_template_new("sink", GST_PAD_SINK, GST_PAD_ALWAYS, caps.get());
    sink_ = Ref<GstPad>::adopt(
        GST_PAD(gst_object_ref_sink(gst_pad_new_from_template(pad_template, "sink"))));
    gst_object_unref(pad_template);
    gst_pad_set_element_private(sink_.get(), this);
    gst_pad_set_chain_function(sink_.get(), on_buffer);
    gst_pad_set_event_function(sink_.get(), on_event);
    const auto out = Ref<GstPad>::adopt(gst_element_get_static_pad(element_.get(), "src"));
    gst_pad_link(out.get(), sink_.get());
    gst_pad_set_active(sink_.get(), TRUE);
  }
  ~ManyInputs() {
    stop();
    for (auto& input : inputs_) drop(input);
    gst_pad_set_active(sink_.get(), FALSE);
    gst_element_set_bus(element_.get(), nullptr);
  }
  ManyInputs(const ManyInputs&) = delete;
  ManyInputs& operator=(const ManyInputs&) = delete;

  GstStateChangeReturn play() { return gst_element_set_state(element_.get(), GST_STATE_PLAYING); }
  void stop() { gst_element_set_state(element_.get(), GST_STATE_NULL); }

  // A new input, with caps and a segment when `caps` is given.
  size_t add(const char* caps, const char* name = "sink_%u") {
    Source source;
    source.pad =
        Ref<GstPad>::adopt(GST_PAD(gst_object_ref_sink(gst_pad_new(nullptr, GST_PAD_SRC))));
    source.sink = Ref<GstPad>::adopt(gst_element_get_static_pad(element_.get(), name));
    source.requested = !source.sink;
    if (source.requested)
      source.sink = Ref<GstPad>::adopt(gst_element_request_pad_simple(element_.get(), name));
    gst_pad_set_active(source.pad.get(), TRUE);
    EXPECT_EQ(gst_pad_link(source.pad.get(), source.sink.get()), GST_PAD_LINK_OK);
    inputs_.push_back(std::move(source));
    const size_t index = inputs_.size() - 1;
    event(index, gst_event_new_stream_start("test"));
    if (caps) set_caps(index, caps);
    return index;
  }
  void set_caps(size_t input, const char* text) {
    const auto caps = Ref<GstCaps>::adopt(gst_caps_from_string(text));
    event(input, gst_event_new_caps(caps.get()));
    GstSegment segment;
    gst_segment_init(&segment, GST_FORMAT_TIME);
    event(input, gst_event_new_segment(&segment));
  }
  void remove(size_t input) { drop(inputs_[input]); }
  bool event(size_t input, GstEvent* event) {
    return gst_pad_push_event(inputs_[input].pad.get(), event);
  }
  GstFlowReturn push(size_t input, Ref<GstBuffer> buffer) {
    return gst_pad_push(inputs_[input].pad.get(), buffer.release());
  }
  GstFlowReturn push(size_t input, const Bytes& bytes, GstClockTime pts) {
    return push(input, buffer_of({bytes}, pts));
  }
  // The same on a thread of its own.
  std::future<GstFlowReturn> push_later(size_t input, Ref<GstBuffer> buffer) {
    return std::async(std::launch::async,
                      [this, input, buffer]() mutable { return push(input, std::move(buffer)); });
  }
  std::future<GstFlowReturn> push_later(size_t input, const Bytes& bytes, GstClockTime pts) {
    return push_later(input, buffer_of({bytes}, pts));
  }
  // One buffer on each of the first inputs; all flow returns must be `flow`.
  void push_all(const std::vector<Bytes>& frames, GstClockTime pts,
                GstFlowReturn flow = GST_FLOW_OK) {
    std::vector<std::future<GstFlowReturn>> pushes;
    for (size_t i = 0; i < frames.size(); ++i) pushes.push_back(push_later(i, frames[i], pts));
    for (size_t i = 0; i < pushes.size(); ++i) {
      if (pushes[i].wait_for(kLongestWait) != std::future_status::ready) {
        ADD_FAILURE() << "waited in vain for the push to input " << i << " to come back";
        stop();
      }
      EXPECT_EQ(pushes[i].get(), flow);
    }
  }

  GstPad* sink_of(size_t input) const { return inputs_[input].sink.get(); }
  GstPad* source_of(size_t input) const { return inputs_[input].pad.get(); }
  GstPad* sink() const { return sink_.get(); }
  GstElement* element() const { return element_.get(); }

  std::vector<Ref<GstBuffer>> buffers() {
    std::lock_guard lock(mutex_);
    return buffers_;
  }
  std::vector<Ref<GstEvent>> events(GstEventType type) {
    std::lock_guard lock(mutex_);
    std::vector<Ref<GstEvent>> out;
    for (const auto& event : events_)
      if (GST_EVENT_TYPE(event.get()) == type) out.push_back(event);
    return out;
  }
  std::vector<std::string> event_names() {
    std::lock_guard lock(mutex_);
    std::vector<std::string> out;
    for (const auto& event : events_) out.emplace_back(GST_EVENT_TYPE_NAME(event.get()));
    return out;
  }
  std::string caps() const {
    const auto caps = Ref<GstCaps>::adopt(gst_pad_get_current_caps(sink_.get()));
    const gst::UniqueText text{caps ? gst_caps_to_string(caps.get()) : g_strdup("")};
    return text.get();
  }
  std::string error() { return message(GST_MESSAGE_ERROR); }
  std::string warning() { return message(GST_MESSAGE_WARNING); }
  guint64 stat(const char* name) const {
    GstStructure* raw = nullptr;
    g_object_get(element_.get(), "stats", &raw, nullptr);
    const gst::Unique<GstStructure, gst_structure_free> stats(raw);
    guint64 value = G_MAXUINT64;
    gst_structure_get_uint64(stats.get(), name, &value);
    return value;
  }
  // In vain, the element is stopped, for who waits in it must come back to let the test end.
  void wait_for_stat(const char* name, guint64 value) {
    const bool came = becomes_true([&] { return stat(name) == value; },
                                   [&] {
                                     return std::string(name) + " = " + std::to_string(value) +
                                            ", which is " + std::to_string(stat(name));
                                   });
    if (!came) stop();
  }

 private:
  struct Source {
    Ref<GstPad> pad, sink;
    bool requested = false;
  };
  void drop(Source& source) {
    if (!source.pad) return;
    if (source.requested) gst_element_release_request_pad(element_.get(), source.sink.get());
    gst_pad_set_active(source.pad.get(), FALSE);
    if (!source.requested) gst_pad_unlink(source.pad.get(), source.sink.get());
    source = {};
  }
  std::string message(GstMessageType type) {
    const gst::Unique<GstMessage, gst_message_unref> found(gst_bus_pop_filtered(bus_.get(), type));
    if (!found) return "";
    GError* error = nullptr;
    if (type == GST_MESSAGE_ERROR)
      gst_message_parse_error(found.get(), &error, nullptr);
    else
      gst_message_parse_warning(found.get(), &error, nullptr);
    const gst::Unique<GError, g_error_free> held(error);
    return error->message;
  }
  static ManyInputs* of(GstPad* pad) {
    return static_cast<ManyInputs*>(gst_pad_get_element_private(pad));
  }
  static GstFlowReturn on_buffer(GstPad* pad, GstObject*, GstBuffer* buffer) {
    ManyInputs* self = of(pad);
    std::lock_guard lock(self->mutex_);
    self->buffers_.push_back(Ref<GstBuffer>::adopt(buffer));
    return GST_FLOW_OK;
  }
  static gboolean on_event(GstPad* pad, GstObject*, GstEvent* event) {
    ManyInputs* self = of(pad);
    std::lock_guard lock(self->mutex_);
    self->events_.push_back(Ref<GstEvent>::adopt(event));
    return TRUE;
  }

  Ref<GstElement> element_;
  Ref<GstBus> bus_;
  Ref<GstPad> sink_;
  std::vector<Source> inputs_;
  std::mutex mutex_;  // guards the rest
  std::vector<Ref<GstBuffer>> buffers_;
  std::vector<Ref<GstEvent>> events_;
};

inline std::string caps_of_bytes(size_t count, const char* rate = "30/1") {
  return "other/tensor,dimension=(string)" + std::to_string(count) +
         ",type=(string)uint8,framerate=(fraction)" + rate;
}

}  // namespace weir::testing
