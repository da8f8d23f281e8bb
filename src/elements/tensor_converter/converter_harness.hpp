// What the tests of tensor_converter share: harnesses, frames, caps, errors from the bus.
#pragma once
#include <gst/check/gstharness.h>
#include <gtest/gtest.h>

#include <numeric>
#include <string>
#include <vector>

#include "gstcpp/ref.hpp"

namespace weir::testing_tensor_converter {

using weir::gst::Mapped;
using weir::gst::Ref;
using weir::gst::Unique;
using Harness = Unique<GstHarness, gst_harness_teardown>;
using Bytes = std::vector<uint8_t>;

inline Harness harness(const std::string& properties, const std::string& caps) {
  Harness h{gst_harness_new_parse(("tensor_converter " + properties).c_str())};
  gst_harness_set_src_caps_str(h.get(), caps.c_str());
  return h;
}
inline std::string video(const std::string& format, int width, int height) {
  return "video/x-raw,format=" + format + ",width=" + std::to_string(width) +
         ",height=" + std::to_string(height) + ",framerate=10/1,interlace-mode=progressive";
}
inline Bytes ramp(size_t size) {
  Bytes out(size);
  std::iota(out.begin(), out.end(), uint8_t{0});
  return out;
}
inline GstBuffer* frame(const Bytes& bytes) {
  GstBuffer* b = gst_buffer_new_allocate(nullptr, bytes.size(), nullptr);
  gst_buffer_fill(b, 0, bytes.data(), bytes.size());
  return b;
}
inline Bytes content(GstBuffer* b) {
  const Mapped map(b, GST_MAP_READ);
  const auto span = map.as<const uint8_t>();
  return {span.begin(), span.end()};
}
inline std::string caps_text(const Harness& h) {
  auto caps = Ref<GstCaps>::adopt(gst_pad_get_current_caps(h->sinkpad));
  const weir::gst::UniqueText text{gst_caps_to_string(caps.get())};
  return text.get();
}
inline uint64_t stat(const Harness& h, const char* name) {
  const auto e = Ref<GstElement>::adopt(gst_harness_find_element(h.get(), "tensor_converter"));
  GstStructure* raw = nullptr;
  g_object_get(e.get(), "stats", &raw, nullptr);
  const Unique<GstStructure, gst_structure_free> stats(raw);
  guint64 value = UINT64_MAX;
  gst_structure_get_uint64(stats.get(), name, &value);
  return value;
}

// What the sink pad answers to a caps query.
inline std::string accepted(const Harness& h, const std::string& filter) {
  auto pad = Ref<GstPad>::adopt(gst_pad_get_peer(h->srcpad));
  auto given = Ref<GstCaps>::adopt(gst_caps_from_string(filter.c_str()));
  auto caps = Ref<GstCaps>::adopt(gst_pad_query_caps(pad.get(), given.get()));
  const weir::gst::UniqueText text{gst_caps_to_string(caps.get())};
  return text.get();
}

inline std::string take_message(GstBus* bus, GstMessageType type) {
  auto message = Ref<GstMessage>::adopt(gst_bus_pop_filtered(bus, type));
  if (!message) return "";
  GError* error = nullptr;
  const bool warning = type == GST_MESSAGE_WARNING;
  (warning ? gst_message_parse_warning : gst_message_parse_error)(message.get(), &error, nullptr);
  const std::string out = error->message;
  g_error_free(error);
  return out;
}

// A bus of its own for a harness's element while it lives.
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
  // "" when there is none
  std::string next() { return take_message(bus_.get(), GST_MESSAGE_ERROR); }
  std::string next_warning() { return take_message(bus_.get(), GST_MESSAGE_WARNING); }

 private:
  GstElement* element_;
  Ref<GstBus> bus_;
};

// The error that a buffer brings; "" when it is taken.
inline std::string error_of(const Harness& h, GstBuffer* buffer) {
  Errors errors(h);
  return gst_harness_push(h.get(), buffer) == GST_FLOW_OK ? "" : errors.next();
}

// The error that caps bring to an element that never had any.
inline std::string caps_error(const std::string& properties, const std::string& text) {
  auto element = Ref<GstElement>::adopt(GST_ELEMENT(
      gst_object_ref_sink(gst_parse_launch(("tensor_converter " + properties).c_str(), nullptr))));
  Errors errors(element.get());
  gst_element_set_state(element.get(), GST_STATE_PAUSED);
  auto pad = Ref<GstPad>::adopt(gst_element_get_static_pad(element.get(), "sink"));
  gst_pad_send_event(pad.get(), gst_event_new_stream_start("test"));
  auto caps = Ref<GstCaps>::adopt(gst_caps_from_string(text.c_str()));
  EXPECT_FALSE(gst_pad_send_event(pad.get(), gst_event_new_caps(caps.get())));
  gst_element_set_state(element.get(), GST_STATE_NULL);
  return errors.next();
}

// The error that other caps bring in the middle of a stream; "" when they are taken. What follows
// refused caps must be refused too.
inline std::string change_caps(const Harness& h, const std::string& text) {
  Errors errors(h);
  auto caps = Ref<GstCaps>::adopt(gst_caps_from_string(text.c_str()));
  gst_harness_push_event(h.get(), gst_event_new_caps(caps.get()));
  const std::string error = errors.next();
  if (!error.empty()) {
    EXPECT_EQ(gst_harness_push(h.get(), frame(ramp(16))), GST_FLOW_NOT_NEGOTIATED);
  }
  return error;
}

#define EXPECT_SAYS(text, words) EXPECT_NE((text).find(words), std::string::npos) << (text)

}  // namespace weir::testing_tensor_converter
