// Converts between values of the modules' C ABI and GStreamer: memory, times, caps.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <cstdint>
#include <string>
#include <vector>

#include "core/infer/module/converted_frame.hpp"
#include "core/ledger/ledger.hpp"
#include "core/tensor/frame_spec.hpp"
#include "gstcpp/buffer/frame_layout.hpp"
#include "gstcpp/buffer/tensor_meta.hpp"
#include "gstcpp/element/ref.hpp"
#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::gst {

// Nanoseconds; -1 for a time that is invalid or too large.
int64_t abi_time(GstClockTime time);
// Nanoseconds since 1970 UTC, -1 = unknown: by the buffer's GstReferenceTimestampMeta of the caps
// timestamp/x-unix or timestamp/x-ntp; else by the element's clock if that is a system clock of
// type realtime.
int64_t get_unix_time(GstBuffer* buffer, const GstSegment& segment, GstElement* element);
// A one-dimensional uint8 tensor over mapped memory, which must stay mapped while it is in use.
weir_tensor byte_tensor(const MappedMemory& memory);
// Wraps the memory of a tensor that a converter made. Memory without a release function belongs to
// the converter and is copied; `ledger` (may be null) counts the copy. Errors: OUT_OF_MEMORY,
// MAPPING_FAILED.
Result<Ref<GstMemory>> make_memory(infer::ConvertedTensor& tensor, Ledger* ledger);
// Parses the caps that a decoder gave as text and adds the frame rate if it is valid.
// CALLBACK_FAILED when the text is not caps, or is EMPTY or ANY.
Result<Ref<GstCaps>> caps_of_decoder(const std::string& text, const Fraction& rate);

// Shapes are outermost-first, without a batch axis.
weir_tensor_info tensor_info(const TensorSpec& spec);

class FrameArguments {
 public:
  // Borrows what `reader` mapped and the times of `buffer`; valid until the next call and while
  // both exist. `with_headers`: the bytes of flexible tensors include their headers.
  const weir_frame& fill(const FrameLayout& reader, GstBuffer* buffer, bool with_headers = false);

 private:
  std::vector<weir_tensor> tensors_;
  FrameMaps maps_;
  weir_frame frame_{};
};

}  // namespace weir::gst
