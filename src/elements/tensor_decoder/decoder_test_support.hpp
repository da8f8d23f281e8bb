// Helpers of the tensor_decoder tests.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "elements/tests/element_test_support.hpp"

namespace weir::testing_tensor_decoder {

using namespace weir::test;

inline Harness harness(const std::string& properties, const std::string& caps) {
  return make_harness("tensor_decoder " + properties, caps);
}
inline std::string tensor(const std::string& type, const std::string& dimensions) {
  return tensors(type, dimensions);
}
template <class T>
GstBuffer* frame(const std::vector<T>& values) {
  return test::frame(values, 7, 3);
}
inline Bytes decoded(const Harness& h, GstBuffer* in) {
  auto out = Ref<GstBuffer>::adopt(gst_harness_push_and_pull(h.get(), in));
  EXPECT_EQ(GST_BUFFER_PTS(out.get()), 7u);
  EXPECT_EQ(GST_BUFFER_DURATION(out.get()), 3u);
  return content(out.get());
}
inline uint64_t stat(const Harness& h, const char* name) {
  return test::stat(h, "tensor_decoder", name);
}

// The first error of the element after start, caps and a frame, each if given.
inline std::string get_error(const std::string& properties, const std::string& caps = "",
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
  return get_text(message.get());
}

}  // namespace weir::testing_tensor_decoder
