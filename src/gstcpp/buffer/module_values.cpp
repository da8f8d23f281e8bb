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

namespace {

// NTP counts from 1900.
constexpr GstClockTime kNtpAtUnixEpoch = GstClockTime{2208988800} * GST_SECOND;

GstClockTime reference_time(GstBuffer* buffer, const char* media_type) {
  gpointer state = nullptr;
  while (GstMeta* meta = gst_buffer_iterate_meta_filtered(buffer, &state,
                                                          GST_REFERENCE_TIMESTAMP_META_API_TYPE)) {
    const auto* found = reinterpret_cast<GstReferenceTimestampMeta*>(meta);
    const GstStructure* reference = gst_caps_get_structure(found->reference, 0);
    if (gst_structure_has_name(reference, media_type)) return found->timestamp;
  }
  return GST_CLOCK_TIME_NONE;
}

// The clock's time of the buffer's running time.
GstClockTime get_realtime(GstBuffer* buffer, const GstSegment& segment, GstElement* element) {
  const auto clock = Ref<GstClock>::adopt(gst_element_get_clock(element));
  if (!clock || !GST_IS_SYSTEM_CLOCK(clock.get())) return GST_CLOCK_TIME_NONE;
  GstClockType type = GST_CLOCK_TYPE_MONOTONIC;
  g_object_get(clock.get(), "clock-type", &type, nullptr);
  if (type != GST_CLOCK_TYPE_REALTIME || segment.format != GST_FORMAT_TIME)
    return GST_CLOCK_TIME_NONE;
  const GstClockTime running =
      gst_segment_to_running_time(&segment, GST_FORMAT_TIME, GST_BUFFER_PTS(buffer));
  const GstClockTime base = gst_element_get_base_time(element);
  if (!GST_CLOCK_TIME_IS_VALID(running) || !GST_CLOCK_TIME_IS_VALID(base))
    return GST_CLOCK_TIME_NONE;
  return base + running;
}

}  // namespace

int64_t get_unix_time(GstBuffer* buffer, const GstSegment& segment, GstElement* element) {
  GstClockTime time = reference_time(buffer, "timestamp/x-unix");
  if (!GST_CLOCK_TIME_IS_VALID(time)) {
    time = reference_time(buffer, "timestamp/x-ntp");
    if (GST_CLOCK_TIME_IS_VALID(time))
      time = time >= kNtpAtUnixEpoch ? time - kNtpAtUnixEpoch : GST_CLOCK_TIME_NONE;
  }
  if (!GST_CLOCK_TIME_IS_VALID(time)) time = get_realtime(buffer, segment, element);
  return time <= static_cast<GstClockTime>(INT64_MAX) ? static_cast<int64_t>(time) : -1;
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

Result<Ref<GstMemory>> make_memory(infer::ConvertedTensor& tensor, Ledger* ledger) {
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

weir_tensor_info tensor_info(const TensorSpec& spec) {
  weir_tensor_info info{};
  info.type = static_cast<uint32_t>(spec.type);
  info.rank = static_cast<uint32_t>(spec.shape.rank());
  for (uint32_t i = 0; i < info.rank; ++i) info.shape[i] = spec.shape[info.rank - 1 - i];
  info.batch_axis = WEIR_NO_BATCH_AXIS;
  return info;
}

const weir_frame& FrameArguments::fill(const FrameLayout& reader, GstBuffer* buffer,
                                       bool with_headers) {
  const auto& views = reader.tensors();
  tensors_.assign(views.size(), weir_tensor{});
  for (size_t i = 0; i < views.size(); ++i) {
    const size_t header = with_headers ? views[i].header_bytes : 0;  // directly before the payload
    tensors_[i].data = views[i].payload.data() - header;
    tensors_[i].bytes = views[i].payload.size() + header;
    tensors_[i].capacity = views[i].capacity + header;
    tensors_[i].flags = WEIR_TENSOR_READONLY;
    tensors_[i].fence_fd = -1;
    tensors_[i].info = tensor_info(views[i].spec);
  }
  frame_ = {};
  frame_.struct_size = sizeof frame_;
  frame_.n_tensors = static_cast<uint32_t>(tensors_.size());
  frame_.tensors = tensors_.data();
  frame_.pts = abi_time(GST_BUFFER_PTS(buffer));
  frame_.duration = abi_time(GST_BUFFER_DURATION(buffer));
  frame_.deadline = -1;
  maps_.fill(buffer, {}, &frame_);
  return frame_;
}

}  // namespace weir::gst
