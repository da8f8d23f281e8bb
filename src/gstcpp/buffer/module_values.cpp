// Converts values of the C ABI; copies memory whose ownership cannot be taken over.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/buffer/module_values.hpp"

#include <algorithm>
#include <cstring>

#include "core/text/shell_quote.hpp"
#include "gstcpp/buffer/allocation.hpp"
#include "gstcpp/buffer/caps_text.hpp"
#include "gstcpp/buffer/frame_errors.hpp"

namespace weir::gst {

int64_t abi_time(GstClockTime time) {
  return GST_CLOCK_TIME_IS_VALID(time) && time <= G_MAXINT64 ? static_cast<int64_t>(time) : -1;
}

weir_tensor byte_tensor(const MappedMemory& memory) {
  weir_tensor tensor{};
  tensor.data = memory.bytes().data();
  tensor.bytes = memory.bytes().size();
  tensor.capacity = memory.capacity();
  tensor.flags = WEIR_TENSOR_READONLY;
  tensor.fence_fd = -1;
  tensor.info.type = WEIR_UINT8;
  tensor.info.rank = 1;
  tensor.info.shape[0] = static_cast<int64_t>(tensor.bytes);
  tensor.info.batch_axis = WEIR_NO_BATCH_AXIS;
  return tensor;
}

Result<Ref<GstMemory>> memory_of(infer::ConvertedTensor& tensor, Ledger* ledger) {
  const auto bytes = static_cast<size_t>(tensor.memory().bytes);
  if (tensor.memory().release) {
    const weir_tensor taken = tensor.take();
    return Ref<GstMemory>::adopt(gst_memory_new_wrapped(GstMemoryFlags(0), taken.data,
                                                        std::max<size_t>(bytes, taken.capacity), 0,
                                                        bytes, taken.owner, taken.release));
  }
  auto copy = allocate_memory(bytes);
  if (!copy) return copy;
  const MappedMemory map(copy->get(), GST_MAP_WRITE);
  if (!map) return memory_not_mapped();
  if (bytes > 0) std::memcpy(map.bytes().data(), tensor.memory().data, bytes);
  if (ledger) ledger->copied(bytes);
  return copy;
}

Result<Ref<GstCaps>> caps_of_decoder(const std::string& text, const Fraction& rate) {
  auto caps = caps_from_text(text);
  if (!caps || gst_caps_is_empty(caps->get()) || gst_caps_is_any(caps->get()))
    return Error{.code = Code::CALLBACK_FAILED,
                 .what = "the decoder returned invalid caps",
                 .offered = quoted_text(text),
                 .needed = "caps as text, for example text/x-raw,format=(string)utf8",
                 .difference = caps ? "" : caps.error().difference + ": " + caps.error().needed,
                 .fix = "fix the decoder's configure"};
  if (rate.valid())
    gst_caps_set_simple(caps->get(), "framerate", GST_TYPE_FRACTION, rate.numerator,
                        rate.denominator, nullptr);
  return caps;
}

}  // namespace weir::gst
