// For tests: tensor_preprocess in a harness, and what it says on its bus.
#pragma once
#include <gst/check/gstharness.h>
#include <gst/video/video.h>
#include <gtest/gtest.h>

#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "gstcpp/ref.hpp"

namespace weir::preprocess_test {

using gst::Mapped;
using gst::Ref;
using gst::Unique;
using Harness = Unique<GstHarness, gst_harness_teardown>;
using Bytes = std::vector<uint8_t>;

inline std::string video(const std::string& format, int width, int height, const char* more = "") {
  return "video/x-raw,format=" + format + ",width=" + std::to_string(width) +
         ",height=" + std::to_string(height) + ",framerate=10/1,interlace-mode=progressive" + more;
}
inline Harness harness(const std::string& properties, const std::string& caps) {
  Harness h{gst_harness_new_parse(("tensor_preprocess " + properties).c_str())};
  gst_harness_set_src_caps_str(h.get(), caps.c_str());
  return h;
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
template <class T>
std::vector<T> pushed(const Harness& h, GstBuffer* in) {
  if (gst_harness_push(h.get(), in) != GST_FLOW_OK) return {};
  const auto out = Ref<GstBuffer>::adopt(gst_harness_try_pull(h.get()));
  if (!out) return {};
  const Mapped map(out.get(), GST_MAP_READ);
  const auto span = map.as<const T>();
  return {span.begin(), span.end()};
}
inline std::string caps_text(const Harness& h) {
  auto caps = Ref<GstCaps>::adopt(gst_pad_get_current_caps(h->sinkpad));
  const gst::UniqueText text{gst_caps_to_string(caps.get())};
  return text.get();
}
inline Unique<GstStructure, gst_structure_free> stats(const Harness& h) {
  const auto e = Ref<GstElement>::adopt(gst_harness_find_element(h.get(), "tensor_preprocess"));
  GstStructure* raw = nullptr;
  g_object_get(e.get(), "stats", &raw, nullptr);
  return Unique<GstStructure, gst_structure_free>(raw);
}
inline uint64_t stat(const Harness& h, const char* name) {
  guint64 value = UINT64_MAX;
  gst_structure_get_uint64(stats(h).get(), name, &value);
  return value;
}

// What the element says on its bus while `run` is at work.
template <class F>
std::string said_by(const Harness& h, GstMessageType type, F&& run) {
  const auto e = Ref<GstElement>::adopt(gst_harness_find_element(h.get(), "tensor_preprocess"));
  const auto bus = Ref<GstBus>::adopt(gst_bus_new());
  gst_element_set_bus(e.get(), bus.get());
  run();
  auto message = Ref<GstMessage>::adopt(gst_bus_pop_filtered(bus.get(), type));
  gst_element_set_bus(e.get(), nullptr);
  if (!message) return "";
  GError* error = nullptr;
  if (type == GST_MESSAGE_WARNING)
    gst_message_parse_warning(message.get(), &error, nullptr);
  else
    gst_message_parse_error(message.get(), &error, nullptr);
  std::string text = error->message;
  g_error_free(error);
  return text;
}
template <class F>
std::string error_of(const Harness& h, F&& run) {
  return said_by(h, GST_MESSAGE_ERROR, std::forward<F>(run));
}
inline std::string error_with_caps(const std::string& properties, const std::string& caps,
                                   const char* behind = nullptr) {
  Harness h{gst_harness_new_parse(("tensor_preprocess " + properties).c_str())};
  if (behind) gst_harness_set_sink_caps_str(h.get(), behind);
  return error_of(h, [&] { gst_harness_set_src_caps_str(h.get(), caps.c_str()); });
}
inline std::string error_of_start(const std::string& properties) {
  auto element = Ref<GstElement>::adopt(GST_ELEMENT(
      gst_object_ref_sink(gst_parse_launch(("tensor_preprocess " + properties).c_str(), nullptr))));
  auto bus = Ref<GstBus>::adopt(gst_bus_new());
  gst_element_set_bus(element.get(), bus.get());
  EXPECT_EQ(gst_element_set_state(element.get(), GST_STATE_PAUSED), GST_STATE_CHANGE_FAILURE);
  auto message = Ref<GstMessage>::adopt(gst_bus_pop_filtered(bus.get(), GST_MESSAGE_ERROR));
  gst_element_set_state(element.get(), GST_STATE_NULL);
  gst_element_set_bus(element.get(), nullptr);
  if (!message) return "";
  GError* error = nullptr;
  gst_message_parse_error(message.get(), &error, nullptr);
  std::string text = error->message;
  g_error_free(error);
  return text;
}
inline void expect_words(const std::string& text, const char* words) {
  EXPECT_NE(text.find(words), std::string::npos) << text << "\nlacks " << words;
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
