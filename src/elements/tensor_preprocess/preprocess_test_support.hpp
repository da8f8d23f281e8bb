// Helpers of the tensor_preprocess tests: a harness, and messages of the element.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/video/video.h>

#include <utility>

#include "elements/tests/element_test_support.hpp"

namespace weir::preprocess_test {

using namespace weir::test;

inline Harness harness(const std::string& properties, const std::string& caps) {
  return make_harness("tensor_preprocess " + properties, caps);
}
template <class T>
std::vector<T> pushed(const Harness& h, GstBuffer* in) {
  if (gst_harness_push(h.get(), in) != GST_FLOW_OK) return {};
  const auto out = Ref<GstBuffer>::adopt(gst_harness_try_pull(h.get()));
  if (!out) return {};
  return values<T>(out.get());
}
inline Unique<GstStructure, gst_structure_free> stats(const Harness& h) {
  return test::stats(find_element(h, "tensor_preprocess").get());
}
inline uint64_t stat(const Harness& h, const char* name) {
  return test::stat(h, "tensor_preprocess", name);
}

// The messages that the element posts during `run`.
template <class F>
std::string text_of_message(const Harness& h, GstMessageType type, F&& run) {
  const auto e = Ref<GstElement>::adopt(gst_harness_find_element(h.get(), "tensor_preprocess"));
  const auto bus = Ref<GstBus>::adopt(gst_bus_new());
  gst_element_set_bus(e.get(), bus.get());
  run();
  const std::string text = take_message(bus.get(), type);
  gst_element_set_bus(e.get(), nullptr);
  return text;
}
template <class F>
std::string get_error(const Harness& h, F&& run) {
  return text_of_message(h, GST_MESSAGE_ERROR, std::forward<F>(run));
}
inline std::string error_with_caps(const std::string& properties, const std::string& caps,
                                   const char* downstream = nullptr) {
  Harness h{gst_harness_new_parse(("tensor_preprocess " + properties).c_str())};
  if (downstream) gst_harness_set_sink_caps_str(h.get(), downstream);
  return get_error(h, [&] { gst_harness_set_src_caps_str(h.get(), caps.c_str()); });
}
inline std::string error_of_start(const std::string& properties) {
  return start_error("tensor_preprocess " + properties);
}

// The frame size in GStreamer's layout.
inline size_t frame_bytes(const std::string& format, guint width, guint height) {
  GstVideoInfo info;
  gst_video_info_set_format(&info, gst_video_format_from_string(format.c_str()), width, height);
  return info.size;
}

inline GstVideoCropMeta* crop(GstBuffer* in, guint x, guint y, guint width, guint height) {
  GstVideoCropMeta* meta = gst_buffer_add_video_crop_meta(in);
  meta->x = x;
  meta->y = y;
  meta->width = width;
  meta->height = height;
  return meta;
}

}  // namespace weir::preprocess_test
