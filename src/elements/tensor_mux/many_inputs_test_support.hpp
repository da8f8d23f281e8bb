// ManyInputs: a test bench with an element of request pads; each input is pushed by its own thread.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>
#include <gtest/gtest.h>

#include <future>
#include <mutex>
#include <string>
#include <vector>

#include "elements/tests/element_parts_test_support.hpp"

namespace weir::test {

using gst::Ref;
using test::Bytes;

inline Ref<GstBuffer> make_buffer(const std::vector<Bytes>& memories, GstClockTime pts) {
  auto buffer = Ref<GstBuffer>::adopt(gst_buffer_new());
  for (const Bytes& bytes : memories)
    gst_buffer_append_memory(buffer.get(), test::make_memory(bytes));
  GST_BUFFER_PTS(buffer.get()) = pts;
  return buffer;
}

inline std::vector<Bytes> read_memories(GstBuffer* buffer) {
  std::vector<Bytes> out;
  for (guint i = 0; i < gst_buffer_n_memory(buffer); ++i)
    out.push_back(test::content(gst_buffer_peek_memory(buffer, i)));
  return out;
}

class ManyInputs {
 public:
  explicit ManyInputs(const std::string& launch, const char* sink_caps = "ANY") {
    element_ = Ref<GstElement>::adopt(GST_ELEMENT(gst_object_ref_sink(
        gst_parse_launch_full(launch.c_str(), nullptr, GST_PARSE_FLAG_FATAL_ERRORS, nullptr))));
    bus_ = Ref<GstBus>::adopt(gst_bus_new());
    gst_element_set_bus(element_.get(), bus_.get());
    sink_ = test::lone_sink_pad(sink_caps);
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

  // Adds an input; sends caps and a segment if `caps` is given.
  size_t add(const char* caps, const char* name = "sink_%u") {
    Source source;
    source.pad = test::lone_pad(gst_pad_new(nullptr, GST_PAD_SRC));
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
    event(input, test::time_segment());
  }
  void remove(size_t input) { drop(inputs_[input]); }
  bool event(size_t input, GstEvent* event) {
    return gst_pad_push_event(inputs_[input].pad.get(), event);
  }
  GstFlowReturn push(size_t input, Ref<GstBuffer> buffer) {
    return gst_pad_push(inputs_[input].pad.get(), buffer.release());
  }
  GstFlowReturn push(size_t input, const Bytes& bytes, GstClockTime pts) {
    return push(input, make_buffer({bytes}, pts));
  }
  // The same on its own thread.
  std::future<GstFlowReturn> push_later(size_t input, Ref<GstBuffer> buffer) {
    return std::async(std::launch::async,
                      [this, input, buffer]() mutable { return push(input, std::move(buffer)); });
  }
  std::future<GstFlowReturn> push_later(size_t input, const Bytes& bytes, GstClockTime pts) {
    return push_later(input, make_buffer({bytes}, pts));
  }
  // Pushes one buffer on each of the first inputs; all flow returns must be `flow`.
  void push_all(const std::vector<Bytes>& frames, GstClockTime pts,
                GstFlowReturn flow = GST_FLOW_OK) {
    std::vector<std::future<GstFlowReturn>> pushes;
    for (size_t i = 0; i < frames.size(); ++i) pushes.push_back(push_later(i, frames[i], pts));
    for (size_t i = 0; i < pushes.size(); ++i) {
      if (pushes[i].wait_for(kMaxWait) != std::future_status::ready) {
        ADD_FAILURE() << "the push to input " << i << " did not return";
        stop();
      }
      EXPECT_EQ(pushes[i].get(), flow);
    }
  }

  GstPad* get_sink(size_t input) const { return inputs_[input].sink.get(); }
  GstPad* get_source(size_t input) const { return inputs_[input].pad.get(); }
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
  std::string caps() const { return test::current_caps(sink_.get()); }
  std::string error() { return test::take_message(bus_.get(), GST_MESSAGE_ERROR); }
  std::string warning() { return test::take_message(bus_.get(), GST_MESSAGE_WARNING); }
  uint64_t stat(const char* name) const { return test::stat(element_.get(), name); }
  // On a timeout the element is stopped, so that blocked threads return and the test can end.
  void wait_for_stat(const char* name, uint64_t value) {
    if (!test::wait_for_stat(element_.get(), name, value)) stop();
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

}  // namespace weir::test
