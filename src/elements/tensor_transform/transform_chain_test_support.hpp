// Helpers for tests of chained transforms: a chain in a harness, its frames, its statistics.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstring>
#include <random>
#include <string>
#include <vector>

#include "elements/tests/element_test_support.hpp"

namespace weir::chain_test {

using gst::Mapped;
using gst::Ref;
using gst::Unique;
using Bytes = std::vector<std::byte>;

// One memory for each tensor of a frame.
using Frame = std::vector<Bytes>;

inline GstBuffer* make_buffer(const Frame& frame) {
  GstBuffer* buffer = gst_buffer_new();
  for (const auto& bytes : frame) {
    GstMemory* memory = gst_allocator_alloc(nullptr, bytes.size(), nullptr);
    GstMapInfo map;
    EXPECT_TRUE(gst_memory_map(memory, &map, GST_MAP_WRITE));
    std::memcpy(map.data, bytes.data(), bytes.size());
    gst_memory_unmap(memory, &map);
    gst_buffer_append_memory(buffer, memory);
  }
  return buffer;
}

inline Frame read_frame(GstBuffer* buffer) {
  Frame frame;
  for (guint i = 0; i < gst_buffer_n_memory(buffer); ++i) {
    const gst::MappedMemory map(gst_buffer_peek_memory(buffer, i), GST_MAP_READ);
    EXPECT_TRUE(map);
    frame.emplace_back(map.bytes().begin(), map.bytes().end());
  }
  return frame;
}

inline Frame random_frame(std::vector<size_t> sizes, uint32_t seed) {
  std::mt19937 random(seed);
  Frame frame;
  for (const size_t size : sizes) {
    auto& bytes = frame.emplace_back(size);
    for (auto& byte : bytes) byte = static_cast<std::byte>(random());
  }
  return frame;
}

// Elements between two pads of a harness, driven by the test's thread.
class Chain {
 public:
  Chain(const std::string& launch, const std::string& caps)
      : harness_(gst_harness_new_parse(launch.c_str())), bus_(Ref<GstBus>::adopt(gst_bus_new())) {
    gst_element_set_bus(harness_->element, bus_.get());
    gst_harness_set_src_caps_str(harness_.get(), caps.c_str());
  }
  ~Chain() { gst_element_set_bus(harness_->element, nullptr); }
  Chain(const Chain&) = delete;
  Chain& operator=(const Chain&) = delete;

  GstHarness* harness() const { return harness_.get(); }
  GstFlowReturn push(const Frame& frame) {
    return gst_harness_push(harness_.get(), make_buffer(frame));
  }
  Ref<GstBuffer> pull() { return Ref<GstBuffer>::adopt(gst_harness_pull(harness_.get())); }
  Frame result(const Frame& frame) {
    EXPECT_EQ(push(frame), GST_FLOW_OK);
    const auto out = pull();
    return out ? read_frame(out.get()) : Frame{};
  }
  void caps(const std::string& caps) { gst_harness_set_src_caps_str(harness_.get(), caps.c_str()); }

  Ref<GstElement> element(const char* name) const {
    GstElement* top = harness_->element;
    return Ref<GstElement>::adopt(GST_IS_BIN(top) ? gst_bin_get_by_name(GST_BIN(top), name)
                                                  : GST_ELEMENT(gst_object_ref(top)));
  }
  uint64_t stat(const char* name, const char* field) const {
    return test::stat(element(name).get(), field);
  }
  void add_probe(const char* name, const char* pad, GstPadProbeCallback callback, gpointer data) {
    const auto at = Ref<GstPad>::adopt(gst_element_get_static_pad(element(name).get(), pad));
    gst_pad_add_probe(at.get(), GST_PAD_PROBE_TYPE_BUFFER, callback, data, nullptr);
  }
  // The text of the last error, prefixed with the name of the element that posted it.
  std::string error() const {
    std::string text;
    while (auto message =
               Ref<GstMessage>::adopt(gst_bus_pop_filtered(bus_.get(), GST_MESSAGE_ERROR))) {
      text =
          std::string(GST_MESSAGE_SRC_NAME(message.get())) + ": " + test::get_text(message.get());
    }
    return text;
  }

 private:
  Unique<GstHarness, gst_harness_teardown> harness_;
  Ref<GstBus> bus_;
};

inline std::string transform(const char* name, const std::string& properties) {
  return std::string("tensor_transform name=") + name + " " + properties;
}

}  // namespace weir::chain_test
