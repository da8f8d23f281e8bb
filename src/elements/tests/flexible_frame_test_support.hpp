// Frames of flexible tensors for tests: each tensor follows its header.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstring>
#include <vector>

#include "core/tensor/tensor_header.hpp"
#include "elements/tests/element_test_support.hpp"

namespace weir::test {

inline constexpr char kFlexibleCaps[] = "other/tensors,format=flexible,framerate=10/1";

// Use gst_buffer_append() to combine several tensors to a frame.
template <class T>
GstBuffer* flexible_frame(const TensorSpec& spec, const std::vector<T>& payload) {
  Bytes out(kTensorHeaderBytes + payload.size() * sizeof(T));
  const auto bytes = std::as_writable_bytes(std::span<uint8_t>(out));
  write_tensor_header({spec, Format::Static, MediaType::Tensor, 0},
                      bytes.template first<kTensorHeaderBytes>());
  if (!payload.empty())
    std::memcpy(out.data() + kTensorHeaderBytes, payload.data(), payload.size() * sizeof(T));
  return frame(out);
}

// The names of the events that the element sent since the last call.
inline std::vector<std::string> event_names(const Harness& h) {
  std::vector<std::string> out;
  while (const auto event = Ref<GstEvent>::adopt(gst_harness_try_pull_event(h.get())))
    out.emplace_back(GST_EVENT_TYPE_NAME(event.get()));
  return out;
}

}  // namespace weir::test
