// Strips the headers of flexible tensors (docs/compatibility/converter.md 2.3).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_converter/flexible_medium.hpp"

#include "core/tensor/packed_tensors.hpp"
#include "core/tensor/tensor_header.hpp"
#include "gstcpp/buffer/frame_builder.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"

namespace weir {
Result<StreamPlan> FlexibleMedium::configure(const GstCaps* caps, const Preferences& preferences) {
  const auto given = gst::spec_from_caps(caps);
  if (!given) return given.error();
  if (given->format != Format::Flexible)
    return Error{.code = Code::FORMAT_UNSUPPORTED,
                 .what = "these tensors need no tensor_converter, or it cannot read them",
                 .offered = std::string("format=") + std::string(to_string(given->format)),
                 .needed = "format=flexible",
                 .fix = "remove tensor_converter from the pipeline"};
  if (auto status = one_frame_each(preferences, "flexible tensors"); !status) return status.error();
  user_ = preferences.tensors;
  StreamPlan plan;
  plan.spec.format = Format::Static;
  plan.spec.rate = get_rate(caps);
  plan_before_the_first(preferences, &plan);
  return plan;
}

Result<MediumFrames> FlexibleMedium::frames(gst::Ref<GstBuffer> buffer, Ledger*) {
  auto tensors = read(buffer.get());
  const bool is_empty = reader_.has_empty_tensor();
  reader_.clear();
  if (!tensors) return tensors.error();
  if (is_empty) return MediumFrames{.buffer = {}, .gap = gst::gap_like(buffer.get())};
  if (auto status = agree(*tensors, user_); !status) return status.error();
  auto out = gst::Ref<GstBuffer>::adopt(gst_buffer_new());
  gst_buffer_copy_into(out.get(), buffer.get(), GST_BUFFER_COPY_METADATA, 0,
                       static_cast<gsize>(-1));
  size_t at = 0;
  for (size_t i = 0; i < tensors->size(); ++i) {
    const bool packed = tensors->size() > kMemoryLimit && i + 1 == kMemoryLimit;
    at += kTensorHeaderBytes + (packed ? kPackedHeaderBytes : 0);
    const auto size = static_cast<size_t>(*(*tensors)[i].bytes());
    gst_buffer_copy_into(out.get(), buffer.get(), GST_BUFFER_COPY_MEMORY, at, size);
    at += size;
  }
  return MediumFrames{std::move(out), *std::move(tensors), {}};
}

// Rejects bytes that belong neither to a header nor to the payload that a header describes.
Result<std::vector<TensorSpec>> FlexibleMedium::read(GstBuffer* buffer) {
  FrameSpec flexible;
  flexible.format = Format::Flexible;
  if (auto status = reader_.read(buffer, flexible); !status) return status.error();
  std::vector<TensorSpec> tensors;
  uint64_t needed = reader_.tensors().size() > kMemoryLimit ? kPackedHeaderBytes : 0;
  for (const auto& view : reader_.tensors()) {
    needed += kTensorHeaderBytes + view.payload.size();
    tensors.push_back(view.spec);
  }
  const size_t size = gst_buffer_get_size(buffer);
  if (size != needed)
    return Error{.code = Code::FRAME_SIZE,
                 .what = "a frame has bytes after its last tensor",
                 .offered = std::to_string(size) + " bytes",
                 .needed = std::to_string(needed) + " bytes",
                 .fix = "check the element or program that wrote the stream"};
  return tensors;
}

}  // namespace weir
