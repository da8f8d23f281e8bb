// Helpers for tests with any driver: creating elements, and reading their statistics and messages.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "becomes.hpp"
#include "gstcpp/element/ref.hpp"
#include "says.hpp"

namespace weir::test {

using gst::Ref;
using gst::Unique;
using Bytes = std::vector<uint8_t>;

// An element or a pipeline outside any bin.
inline Ref<GstElement> lone_element(const std::string& launch) {
  GError* raw = nullptr;
  GstElement* made = gst_parse_launch(launch.c_str(), &raw);
  const Unique<GError, g_error_free> error(raw);
  EXPECT_FALSE(error) << launch << ": " << error->message;
  return Ref<GstElement>::adopt(GST_ELEMENT(gst_object_ref_sink(made)));
}
// All elements of the plug-in.
inline std::vector<std::string> element_names() {
  std::vector<std::string> out;
  GList* all = gst_registry_get_feature_list_by_plugin(gst_registry_get(), "weir");
  for (GList* item = all; item; item = item->next)
    if (GST_IS_ELEMENT_FACTORY(item->data))
      out.emplace_back(gst_plugin_feature_get_name(GST_PLUGIN_FEATURE(item->data)));
  gst_plugin_feature_list_free(all);
  return out;
}
// A pad without an element, as returned by gst_pad_new() and similar functions.
inline Ref<GstPad> lone_pad(GstPad* made) {
  return Ref<GstPad>::adopt(GST_PAD(gst_object_ref_sink(made)));
}
// A sink pad that accepts only these caps.
inline Ref<GstPad> lone_sink_pad(const std::string& caps_text, const std::string& name = "sink") {
  const auto caps = Ref<GstCaps>::adopt(gst_caps_from_string(caps_text.c_str()));
  const auto pad_template = Ref<GstPadTemplate>::adopt(GST_PAD_TEMPLATE(
      gst_object_ref_sink(gst_pad_template_new("sink", GST_PAD_SINK, GST_PAD_ALWAYS, caps.get()))));
  return lone_pad(gst_pad_new_from_template(pad_template.get(), name.c_str()));
}

// Caps of static tensors; dimensions and types are comma-separated, one item per tensor.
inline std::string tensors(const std::string& types, const std::string& dimensions,
                           const std::string& rate = "30/1") {
  const auto count = 1 + std::count(types.begin(), types.end(), ',');
  return "other/tensors,format=static,num_tensors=" + std::to_string(count) +
         ",dimensions=(string)\"" + dimensions + "\",types=(string)\"" + types +
         "\",framerate=" + rate;
}
// "" without caps.
inline std::string current_caps(GstPad* pad) {
  const auto caps = Ref<GstCaps>::adopt(gst_pad_get_current_caps(pad));
  if (!caps) return "";
  const gst::UniqueText text{gst_caps_to_string(caps.get())};
  return text.get();
}
inline GstEvent* time_segment() {
  GstSegment segment;
  gst_segment_init(&segment, GST_FORMAT_TIME);
  return gst_event_new_segment(&segment);
}

inline GstMemory* make_memory(const Bytes& bytes) {
  GstMemory* memory = gst_allocator_alloc(nullptr, bytes.size(), nullptr);
  const gst::MappedMemory map(memory, GST_MAP_WRITE);
  std::copy(bytes.begin(), bytes.end(), reinterpret_cast<uint8_t*>(map.bytes().data()));
  return memory;
}
inline Bytes content(GstMemory* memory) {
  const gst::MappedMemory map(memory, GST_MAP_READ);
  const auto* data = reinterpret_cast<const uint8_t*>(map.bytes().data());
  return {data, data + map.bytes().size()};
}

inline Unique<GstStructure, gst_structure_free> stats(GstElement* element) {
  GstStructure* raw = nullptr;
  g_object_get(element, "stats", &raw, nullptr);
  return Unique<GstStructure, gst_structure_free>(raw);
}
// One value of the property `stats`.
inline uint64_t stat(GstElement* element, const char* name) {
  guint64 value = UINT64_MAX;
  EXPECT_TRUE(gst_structure_get_uint64(stats(element).get(), name, &value)) << name;
  return value;
}
// Waits until it reaches `value`; otherwise fails the test.
inline bool wait_for_stat(GstElement* element, const char* name, uint64_t value) {
  return becomes_true([&] { return stat(element, name) == value; },
                      [&] {
                        return std::string(name) + " = " + std::to_string(value) + ", which is " +
                               std::to_string(stat(element, name));
                      });
}

// The GError of an error or a warning.
inline Unique<GError, g_error_free> error_in(GstMessage* message) {
  GError* error = nullptr;
  if (GST_MESSAGE_TYPE(message) == GST_MESSAGE_WARNING)
    gst_message_parse_warning(message, &error, nullptr);
  else
    gst_message_parse_error(message, &error, nullptr);
  return Unique<GError, g_error_free>(error);
}
// Its text; "" if there is none.
inline std::string get_text(GstMessage* message) {
  return message ? error_in(message)->message : "";
}
inline std::string take_message(GstBus* bus, GstMessageType type) {
  return get_text(Ref<GstMessage>::adopt(gst_bus_pop_filtered(bus, type)).get());
}

}  // namespace weir::test
