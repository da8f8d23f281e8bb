// Helpers of all element tests: a harness, frames, caps, statistics, bus messages.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/check/gstharness.h>

#include <numeric>
#include <string>
#include <vector>

#include "elements/tests/element_parts_test_support.hpp"

namespace weir::test {

using gst::Mapped;
using Harness = Unique<GstHarness, gst_harness_teardown>;

// Elements between two test pads. An empty text sends no caps.
inline Harness make_harness(const std::string& launch, const std::string& caps = "") {
  Harness h{gst_harness_new_parse(launch.c_str())};
  if (!caps.empty()) gst_harness_set_src_caps_str(h.get(), caps.c_str());
  return h;
}

inline std::string video(const std::string& format, int width, int height,
                         const std::string& more = "") {
  return "video/x-raw,format=" + format + ",width=" + std::to_string(width) +
         ",height=" + std::to_string(height) + ",framerate=10/1,interlace-mode=progressive" + more;
}

// 0, 1, 2, ... 255, 0, ...
inline Bytes ramp(size_t size) {
  Bytes out(size);
  std::iota(out.begin(), out.end(), uint8_t{0});
  return out;
}
template <class T = uint8_t>
GstBuffer* frame(const std::vector<T>& values, GstClockTime time = GST_CLOCK_TIME_NONE,
                 GstClockTime duration = GST_CLOCK_TIME_NONE) {
  GstBuffer* b = gst_buffer_new_allocate(nullptr, values.size() * sizeof(T), nullptr);
  gst_buffer_fill(b, 0, values.data(), values.size() * sizeof(T));
  GST_BUFFER_PTS(b) = time;
  GST_BUFFER_DURATION(b) = duration;
  return b;
}
template <class T>
std::vector<T> values(GstBuffer* b) {
  const Mapped map(b, GST_MAP_READ);
  const auto span = map.template as<const T>();
  return {span.begin(), span.end()};
}
inline Bytes content(GstBuffer* b) {
  return values<uint8_t>(b);
}

// The caps of the output.
inline std::string caps_text(const Harness& h) {
  return current_caps(h->sinkpad);
}

inline Ref<GstElement> find_element(const Harness& h, const char* factory) {
  return Ref<GstElement>::adopt(gst_harness_find_element(h.get(), factory));
}
inline uint64_t stat(const Harness& h, const char* factory, const char* name) {
  return stat(find_element(h, factory).get(), name);
}
inline bool wait_for_stat(const Harness& h, const char* factory, const char* name, uint64_t value) {
  return wait_for_stat(find_element(h, factory).get(), name, value);
}

// A separate bus for an element, or for the element of a harness, within a scope.
class Errors {
 public:
  explicit Errors(const Harness& h) : Errors(h->element) {}
  explicit Errors(GstElement* element)
      : element_(element), bus_(Ref<GstBus>::adopt(gst_bus_new())) {
    gst_element_set_bus(element_, bus_.get());
  }
  Errors(const Errors&) = delete;
  Errors& operator=(const Errors&) = delete;
  ~Errors() { gst_element_set_bus(element_, nullptr); }
  // "" if there is none
  std::string next() { return take_message(bus_.get(), GST_MESSAGE_ERROR); }
  std::string next_warning() { return take_message(bus_.get(), GST_MESSAGE_WARNING); }

 private:
  GstElement* element_;
  Ref<GstBus> bus_;
};

// The first error of an element that is set to PAUSED and then given caps, if any.
inline std::string start_error(const std::string& launch, const std::string& caps = "") {
  const auto element = lone_element(launch);
  Errors errors(element.get());
  gst_element_set_state(element.get(), GST_STATE_PAUSED);
  if (!caps.empty()) {
    const auto pad = Ref<GstPad>::adopt(gst_element_get_static_pad(element.get(), "sink"));
    gst_pad_send_event(pad.get(), gst_event_new_stream_start("test"));
    const auto given = Ref<GstCaps>::adopt(gst_caps_from_string(caps.c_str()));
    gst_pad_send_event(pad.get(), gst_event_new_caps(given.get()));
  }
  const std::string error = errors.next();  // a pipeline flushes its bus when it goes to NULL
  gst_element_set_state(element.get(), GST_STATE_NULL);
  return error;
}

// The error of an element that receives a buffer before caps.
inline std::string error_before_caps(const std::string& launch) {
  const auto element = lone_element(launch);
  Errors errors(element.get());
  gst_element_set_state(element.get(), GST_STATE_PAUSED);
  const auto pad = Ref<GstPad>::adopt(gst_element_get_static_pad(element.get(), "sink"));
  gst_pad_send_event(pad.get(), gst_event_new_stream_start("test"));
  gst_pad_send_event(pad.get(), time_segment());
  EXPECT_EQ(gst_pad_chain(pad.get(), frame(Bytes(1))), GST_FLOW_NOT_NEGOTIATED);
  const std::string error = errors.next();
  gst_element_set_state(element.get(), GST_STATE_NULL);
  return error;
}

}  // namespace weir::test
