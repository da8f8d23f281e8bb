// Converts between values of the modules' C ABI and GStreamer: memory, times, caps.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <string>

#include "core/infer/module/converted_frame.hpp"
#include "core/ledger/ledger.hpp"
#include "core/tensor/frame_spec.hpp"
#include "gstcpp/element/ref.hpp"
#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::gst {

// Nanoseconds; -1 for a time that is invalid or too large.
int64_t abi_time(GstClockTime time);
// A one-dimensional uint8 tensor over mapped memory, which must stay mapped while it is in use.
weir_tensor byte_tensor(const MappedMemory& memory);
// Wraps the memory of a tensor that a converter made. Memory without a release function belongs to
// the converter and is copied; `ledger` (may be null) counts the copy. Errors: OUT_OF_MEMORY,
// MAPPING_FAILED.
Result<Ref<GstMemory>> memory_of(infer::ConvertedTensor& tensor, Ledger* ledger);
// Parses the caps that a decoder gave as text and adds the frame rate if it is valid.
// CALLBACK_FAILED when the text is not caps, or is EMPTY or ANY.
Result<Ref<GstCaps>> caps_of_decoder(const std::string& text, const Fraction& rate);

}  // namespace weir::gst
