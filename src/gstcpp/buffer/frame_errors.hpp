// Errors of buffers that do not match their caps.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <string>
#include <utility>

#include "core/tensor/frame_spec.hpp"
#include "core/tensor/packed_tensors.hpp"

namespace weir::gst {

inline Error wrong_frame_size(std::string offered, std::string needed,
                              std::string difference = {}) {
  return Error{.code = Code::FRAME_SIZE,
               .what = "the size of a buffer does not match its caps",
               .offered = std::move(offered),
               .needed = std::move(needed),
               .difference = std::move(difference),
               .fix = "check the upstream element: its caps and its buffers must agree"};
}

inline Error wrong_frame_size(const FrameSpec& spec, std::string offered, std::string difference) {
  return wrong_frame_size(
      std::move(offered),
      spec.to_string() + (spec.bytes() ? " = " + std::to_string(*spec.bytes()) + " bytes" : ""),
      std::move(difference));
}

inline Error wrong_frame_size(const FrameSpec& spec, GstBuffer* buffer,
                              const std::string& difference) {
  const auto memories = gst_buffer_n_memory(buffer);
  return wrong_frame_size(spec,
                          std::to_string(gst_buffer_get_size(buffer)) + " bytes in " +
                              std::to_string(memories) + (memories == 1 ? " memory" : " memories"),
                          difference);
}

// Adds the pad on which the buffer arrived, for elements with many pads.
inline Error on_pad(Error error, const std::string& pad) {
  error.offered += (error.offered.empty() ? "on " : " on ") + pad;
  return error;
}

// OK for a buffer of the size that its caps give, with or without the packed header.
inline Status whole_frame(const FrameSpec& spec, uint64_t bytes) {
  const auto needed = spec.bytes();
  const bool packed = spec.tensors.size() > kMemoryLimit;
  if (needed && (bytes == *needed || (packed && bytes == *needed + kPackedHeaderBytes)))
    return ok();
  return wrong_frame_size(spec, std::to_string(bytes) + " bytes", "");
}

inline Error buffer_is_empty() {
  return Error{.code = Code::FRAME_SIZE,
               .what = "a buffer is empty",
               .offered = "0 bytes",
               .needed = "at least one tensor",
               .fix = "check the element or program that wrote the stream"};
}

inline Error memory_not_mapped() {
  return Error{.code = Code::MAPPING_FAILED,
               .what = "the memory of a buffer cannot be mapped",
               .needed = "system memory",
               .fix = "insert the element that downloads from the device, for example gldownload"};
}

inline Error output_not_writable() {
  return Error{.code = Code::MAPPING_FAILED,
               .what = "an output buffer cannot be mapped for writing"};
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
