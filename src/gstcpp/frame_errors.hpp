// Errors of buffers that are not what their caps say.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <string>

#include "core/tensor/frame_spec.hpp"
#include "core/tensor/packed_tensors.hpp"

namespace weir::gst {

inline Error wrong_frame_size(const FrameSpec& spec, const std::string& offered,
                              const std::string& difference) {
  return Error{
      Code::FRAME_SIZE,
      "a buffer has another size than its caps say",
      offered,
      spec.to_string() + (spec.bytes() ? " = " + std::to_string(*spec.bytes()) + " bytes" : ""),
      difference,
      "check the element before this one: its caps and its buffers must agree"};
}

inline Error wrong_frame_size(const FrameSpec& spec, GstBuffer* buffer,
                              const std::string& difference) {
  const auto memories = gst_buffer_n_memory(buffer);
  return wrong_frame_size(spec,
                          std::to_string(gst_buffer_get_size(buffer)) + " bytes in " +
                              std::to_string(memories) + (memories == 1 ? " memory" : " memories"),
                          difference);
}

// The same, where an element has many pads: which one it came to.
inline Error on_pad(Error error, const std::string& pad) {
  error.offered += (error.offered.empty() ? "on " : " on ") + pad;
  return error;
}

// OK for a buffer as large as its caps say, with the packed header or without it.
inline Status whole_frame(const FrameSpec& spec, uint64_t bytes) {
  const auto needed = spec.bytes();
  const bool packed = spec.tensors.size() > kMemoryLimit;
  if (needed && (bytes == *needed || (packed && bytes == *needed + kPackedHeaderBytes)))
    return ok();
  return wrong_frame_size(spec, std::to_string(bytes) + " bytes", "");
}

inline Error buffer_is_empty() {
  return Error{Code::FRAME_SIZE,
               "a buffer is empty",
               "0 bytes",
               "at least one tensor",
               "",
               "check the element or program that wrote the stream"};
}

inline Error memory_not_mapped() {
  return Error{
      Code::MAP_FAILED,
      "the memory of a buffer cannot be mapped",
      "",
      "system memory",
      "",
      "put the element that downloads from the device in between (gldownload, for example)"};
}

inline Error memory_ran_out(uint64_t bytes) {
  return Error{.code = Code::OUT_OF_MEMORY,
               .what = "memory ran out",
               .offered = {},
               .needed = std::to_string(bytes) + " bytes for a buffer",
               .difference = {},
               .fix = {}};
}

}  // namespace weir::gst
