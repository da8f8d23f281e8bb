// Converts buffers to tensors and checks their bounds.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "pipeline/pulled_frame.hpp"

#include "gstcpp/buffer/frame_errors.hpp"
#include "gstcpp/buffer/memory_part.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"

namespace weir::pipeline {
namespace {

bool is_tensors(const GstCaps* caps) {
  const GstStructure* s = gst_caps_get_structure(caps, 0);
  return gst_structure_has_name(s, "other/tensor") || gst_structure_has_name(s, "other/tensors");
}

int64_t time_of(GstClockTime time) {
  return GST_CLOCK_TIME_IS_VALID(time) ? static_cast<int64_t>(time) : -1;
}

}  // namespace

Result<std::shared_ptr<const PulledFrame>> PulledFrame::read(gst::Ref<GstBuffer> buffer,
                                                             const gst::Ref<GstCaps>& caps) {
  std::shared_ptr<PulledFrame> out(new PulledFrame(std::move(buffer)));
  if (caps) out->caps_ = gst::UniqueText(gst_caps_to_string(caps.get())).get();
  Status status = ok();
  if (caps && !gst_caps_is_any(caps.get()) && !gst_caps_is_empty(caps.get()) &&
      is_tensors(caps.get())) {
    const auto spec = gst::fixed_spec_from_caps(caps.get());
    status = spec ? out->read_tensors(*spec) : Status(spec.error());
  } else {
    status = out->read_bytes();
  }
  if (!status) return status.error();
  return std::shared_ptr<const PulledFrame>(std::move(out));
}

PulledFrame::~PulledFrame() {
  reader_.clear();
}

Status PulledFrame::read_tensors(const FrameSpec& spec) {
  if (spec.format == Format::Sparse)
    return Error{.code = Code::FORMAT_UNSUPPORTED,
                 .what = "sparse tensors cannot be pulled",
                 .offered = caps_,
                 .needed = "static or flexible tensors",
                 .fix = "tensor_sparse_dec before the sink"};
  if (auto status = reader_.read(buffer_.get(), spec); !status) return status;
  for (const auto& view : reader_.tensors()) add(view.spec, view.payload);
  return ok();
}

Status PulledFrame::read_bytes() {
  // Mapping several memories at once would end the process if their copy cannot be allocated.
  auto memory = gst::one_memory(buffer_.get());
  if (!memory) return memory.error();
  memory_ = *std::move(memory);
  bytes_ = gst::MappedMemory(memory_.get(), GST_MAP_READ);
  if (!bytes_) return gst::memory_not_mapped();
  TensorSpec spec{ElementType::UInt8, Shape{1}, ""};
  add(spec, bytes_.bytes());
  tensors_[0].info.rank = 1;
  tensors_[0].info.shape[0] = static_cast<int64_t>(bytes_.bytes().size());
  return ok();
}

void PulledFrame::add(const TensorSpec& spec, std::span<std::byte> bytes) {
  weir_tensor tensor{};
  tensor.data = bytes.data();
  tensor.bytes = tensor.capacity = bytes.size();
  tensor.memory_kind = WEIR_MEMORY_HOST;
  tensor.flags = WEIR_TENSOR_READONLY;
  tensor.fence_fd = -1;
  tensor.info.type = static_cast<uint32_t>(spec.type);
  tensor.info.batch_axis = WEIR_NO_BATCH_AXIS;
  tensor.info.rank = static_cast<uint32_t>(spec.shape.rank());
  for (uint32_t i = 0; i < tensor.info.rank; ++i)
    tensor.info.shape[i] = spec.shape[tensor.info.rank - 1 - i];
  tensors_.push_back(tensor);
}

int64_t PulledFrame::pts() const noexcept {
  return time_of(GST_BUFFER_PTS(buffer_.get()));
}

int64_t PulledFrame::duration() const noexcept {
  return time_of(GST_BUFFER_DURATION(buffer_.get()));
}

}  // namespace weir::pipeline
