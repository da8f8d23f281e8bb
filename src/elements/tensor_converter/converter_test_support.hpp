// Helpers of the tensor_converter tests.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "elements/tests/element_test_support.hpp"

namespace weir::testing_tensor_converter {

using namespace weir::test;

inline Harness harness(const std::string& properties, const std::string& caps) {
  return make_harness("tensor_converter " + properties, caps);
}
inline uint64_t stat(const Harness& h, const char* name) {
  return test::stat(h, "tensor_converter", name);
}

// The result of a caps query on the sink pad.
inline std::string accepted(const Harness& h, const std::string& filter) {
  auto pad = Ref<GstPad>::adopt(gst_pad_get_peer(h->srcpad));
  auto given = Ref<GstCaps>::adopt(gst_caps_from_string(filter.c_str()));
  auto caps = Ref<GstCaps>::adopt(gst_pad_query_caps(pad.get(), given.get()));
  const weir::gst::UniqueText text{gst_caps_to_string(caps.get())};
  return text.get();
}

// The error that a buffer causes; "" if it is accepted.
inline std::string get_error(const Harness& h, GstBuffer* buffer) {
  Errors errors(h);
  return gst_harness_push(h.get(), buffer) == GST_FLOW_OK ? "" : errors.next();
}

// The error that caps cause in a new element.
inline std::string caps_error(const std::string& properties, const std::string& text) {
  const auto element = lone_element("tensor_converter " + properties);
  Errors errors(element.get());
  gst_element_set_state(element.get(), GST_STATE_PAUSED);
  auto pad = Ref<GstPad>::adopt(gst_element_get_static_pad(element.get(), "sink"));
  gst_pad_send_event(pad.get(), gst_event_new_stream_start("test"));
  auto caps = Ref<GstCaps>::adopt(gst_caps_from_string(text.c_str()));
  EXPECT_FALSE(gst_pad_send_event(pad.get(), gst_event_new_caps(caps.get())));
  gst_element_set_state(element.get(), GST_STATE_NULL);
  return errors.next();
}

// The error that a caps change causes during a stream; "" if accepted. Buffers after rejected caps
// must be rejected too.
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

}  // namespace weir::testing_tensor_converter
