// What the tests of tensor_decoder share: harnesses, frames, caps, errors from the bus.
#pragma once
#include <gst/check/gstharness.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "gstcpp/ref.hpp"

namespace weir::testing_tensor_decoder {

using weir::gst::Mapped;
using weir::gst::Ref;
using weir::gst::Unique;
using Harness = Unique<GstHarness, gst_harness_teardown>;
using Bytes = std::vector<uint8_t>;

inline Harness harness(const std::string& properties, const std::string& caps) {
  Harness h{gst_harness_new_parse(("tensor_decoder " + properties).c_str())};
  gst_harness_set_src_caps_str(h.get(), caps.c_str());
  return h;
}
inline std::string tensor(const std::string& type, const std::string& dimensions) {
  return "other/tensors,format=static,num_tensors=1,dimensions=(string)" + dimensions +
         ",types=" + type + ",framerate=30/1";
}
template <class T>
GstBuffer* frame(const std::vector<T>& values) {
  GstBuffer* b = gst_buffer_new_allocate(nullptr, values.size() * sizeof(T), nullptr);
  gst_buffer_fill(b, 0, values.data(), values.size() * sizeof(T));
  GST_BUFFER_PTS(b) = 7;
  GST_BUFFER_DURATION(b) = 3;
  return b;
}
inline Bytes content(GstBuffer* b) {
  const Mapped map(b, GST_MAP_READ);
  const auto span = map.as<const uint8_t>();
  return {span.begin(), span.end()};
}
inline Bytes decoded(const Harness& h, GstBuffer* in) {
  auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), in));
  EXPECT_EQ(GST_BUFFER_PTS(out.get()), 7u);
  EXPECT_EQ(GST_BUFFER_DURATION(out.get()), 3u);
  return content(out.get());
}
inline std::string caps_text(const Harness& h) {
  auto caps = Ref<GstCaps>::adopt(gst_pad_get_current_caps(h->sinkpad));
  const weir::gst::UniqueText text{gst_caps_to_string(caps.get())};
  return text.get();
}
inline uint64_t stat(const Harness& h, const char* name) {
  const auto e = Ref<GstElement>::adopt(gst_harness_find_element(h.get(), "tensor_decoder"));
  GstStructure* raw = nullptr;
  g_object_get(e.get(), "stats", &raw, nullptr);
  const Unique<GstStructure, gst_structure_free> stats(raw);
  guint64 value = UINT64_MAX;
  gst_structure_get_uint64(stats.get(), name, &value);
  return value;
}

inline std::string text_of(GstMessage* message) {
  if (!message) return "";
  GError* error = nullptr;
  gst_message_parse_error(message, &error, nullptr);
  const std::string text = error->message;
  g_error_free(error);
  return text;
}

// The first error of the element, started, given caps and, if there are any, a frame.
inline std::string error_of(const std::string& properties, const std::string& caps = "",
                            const Bytes& bytes = {}) {
  const Unique<GstElement, gst_object_unref> pipeline(gst_parse_launch(
      ("appsrc name=in format=time ! tensor_decoder " + properties + " ! fakesink async=false")
          .c_str(),
      nullptr));
  const auto bus = Ref<GstBus>::adopt(gst_element_get_bus(pipeline.get()));
  const auto result = gst_element_set_state(pipeline.get(), GST_STATE_PLAYING);
  if (result != GST_STATE_CHANGE_FAILURE && !caps.empty()) {
    const auto in = Ref<GstElement>::adopt(gst_bin_get_by_name(GST_BIN(pipeline.get()), "in"));
    const auto given = Ref<GstCaps>::adopt(gst_caps_from_string(caps.c_str()));
    g_object_set(in.get(), "caps", given.get(), nullptr);
    GstFlowReturn flow;
    g_signal_emit_by_name(in.get(), "push-buffer", Ref<GstBuffer>::adopt(frame(bytes)).get(),
                          &flow);
    g_signal_emit_by_name(in.get(), "end-of-stream", &flow);
  }
  const auto message = Ref<GstMessage>::adopt(gst_bus_timed_pop_filtered(
      bus.get(), 10 * GST_SECOND, GstMessageType(GST_MESSAGE_ERROR | GST_MESSAGE_EOS)));
  gst_element_set_state(pipeline.get(), GST_STATE_NULL);
  if (!message || GST_MESSAGE_TYPE(message.get()) != GST_MESSAGE_ERROR) return "";
  return text_of(message.get());
}

#define EXPECT_SAYS(text, words) EXPECT_NE((text).find(words), std::string::npos) << (text)

}  // namespace weir::testing_tensor_decoder
