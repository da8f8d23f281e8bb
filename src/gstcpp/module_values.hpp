// What modules give and take by the C ABI, as GStreamer has it: memory, times, caps.
#pragma once
#include <gst/gst.h>

#include <string>

#include "core/infer/converted_frame.hpp"
#include "core/ledger/ledger.hpp"
#include "core/tensor/frame_spec.hpp"
#include "gstcpp/ref.hpp"
#include "weir/abi.h"
#include "weir/result.hpp"

namespace weir::gst {

// Nanoseconds; -1 for what is not known or too large.
int64_t abi_time(GstClockTime time);
// A uint8 tensor of one dimension over mapped memory, which must stay mapped while it is used.
weir_tensor byte_tensor(const MappedMemory& memory);
// The memory of a tensor that a converter made. What has no release is the converter's own and is
// copied; `ledger`, which may be null, counts that. Errors: OUT_OF_MEMORY, MAP_FAILED.
Result<Ref<GstMemory>> memory_of(infer::ConvertedTensor& tensor, Ledger* ledger);
// The caps that a decoder gave as text, with the frame rate where it is valid. CALLBACK_FAILED for
// what is no caps, empty or any.
Result<Ref<GstCaps>> caps_of_decoder(const std::string& text, const Fraction& rate);

}  // namespace weir::gst
