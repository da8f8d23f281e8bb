// SPDX-License-Identifier: LGPL-2.1-or-later
#include "pipeline/pulled_frame.hpp"

#include "gstcpp/buffer/frame_errors.hpp"
#include "gstcpp/buffer/memory_part.hpp"
#include "gstcpp/buffer/module_values.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"
#include "gstcpp/buffer/tensor_meta.hpp"
#include "weir/results.h"

namespace weir::pipeline {
namespace {

bool is_tensors(const GstCaps* caps) {
  const GstStructure* s = gst_caps_get_structure(caps, 0);
  return gst_structure_has_name(s, "other/tensor") || gst_structure_has_name(s, "other/tensors");
}

int64_t to_time(GstClockTime time) {
  return GST_CLOCK_TIME_IS_VALID(time) ? static_cast<int64_t>(time) : -1;
}

}  // namespace

Result<std::shared_ptr<const PulledFrame>> PulledFrame::read(gst::Ref<GstBuffer> buffer,
                                                             gst::Ref<GstCaps> given,
                                                             std::shared_ptr<const Labels> labels) {
  std::shared_ptr<PulledFrame> out(
      new PulledFrame(std::move(buffer), std::move(given), std::move(labels)));
  const auto& caps = out->caps_;
  if (caps) out->caps_text_ = gst::UniqueText(gst_caps_to_string(caps.get())).get();
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
                 .offered = caps_text_,
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
  tensor.info = gst::tensor_info(spec);
  tensors_.push_back(tensor);
}

const char* PulledFrame::caps_field(const char* field) const noexcept {
  if (!caps_ || gst_caps_get_size(caps_.get()) == 0) return "";
  const char* text = gst_structure_get_string(gst_caps_get_structure(caps_.get(), 0), field);
  return text ? text : "";
}

const char* PulledFrame::label(uint32_t index, int32_t class_index) const {
  if (!labels_ || class_index < 0) return "";
  std::string_view sources = caps_field(WEIR_RESULTS_SOURCE);
  for (; index > 0; --index) {
    const size_t end = sources.find(';');
    if (end == std::string_view::npos) return "";
    sources.remove_prefix(end + 1);
  }
  const auto found = labels_->find(sources.substr(0, sources.find(';')));
  const auto at = static_cast<size_t>(class_index);
  return found != labels_->end() && at < found->second.size() ? found->second[at].c_str() : "";
}

std::span<const SourceMap> PulledFrame::maps() const noexcept {
  return gst::source_maps(buffer_.get());
}

int64_t PulledFrame::pts() const noexcept {
  return to_time(GST_BUFFER_PTS(buffer_.get()));
}

int64_t PulledFrame::duration() const noexcept {
  return to_time(GST_BUFFER_DURATION(buffer_.get()));
}

}  // namespace weir::pipeline
