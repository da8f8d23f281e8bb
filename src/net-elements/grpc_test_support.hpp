// Helpers of the tests of both gRPC elements: their ports, frames over a real connection.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "becomes.hpp"
#include "elements/tests/element_test_support.hpp"
#include "elements/tests/pipeline_test_support.hpp"
#include "says.hpp"

namespace weir::test {

// Of an element with port=0 that is PAUSED.
inline std::string get_port(const Harness& h, const char* factory) {
  gint port = 0;
  g_object_get(find_element(h, factory).get(), "port", &port, nullptr);
  return " port=" + std::to_string(port);
}

inline const std::string kSixBytes =
    "other/tensors,format=static,num_tensors=2,dimensions=(string)\"3:1,3\","
    "types=(string)\"uint8,uint8\",framerate=(fraction)5/1";

// A frame of kSixBytes.
inline GstBuffer* six_bytes(uint8_t first) {
  GstBuffer* out = gst_buffer_new();
  for (int i = 0; i < 2; ++i, first = static_cast<uint8_t>(first + 3)) {
    GstMemory* memory = gst_allocator_alloc(nullptr, 3, nullptr);
    const gst::MappedMemory map(memory, GST_MAP_WRITE);
    for (size_t k = 0; k < 3; ++k) map.bytes()[k] = static_cast<std::byte>(first + k);
    gst_buffer_append_memory(out, memory);
  }
  return out;
}

inline Bytes pulled_bytes(const Harness& h) {
  const auto buffer = Ref<GstBuffer>::adopt(gst_harness_pull(h.get()));
  return buffer ? content(buffer.get()) : Bytes{};
}

// Whether the stream ends before another frame comes.
inline bool ends(const Harness& h) {
  return becomes_true(
      [&] {
        const auto event = Ref<GstEvent>::adopt(gst_harness_try_pull_event(h.get()));
        return event && GST_EVENT_TYPE(event.get()) == GST_EVENT_EOS;
      },
      "the end of the stream");
}

}  // namespace weir::test
