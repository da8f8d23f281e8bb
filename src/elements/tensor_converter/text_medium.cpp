// Text as tensors (specification 2, "text").
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_converter/text_medium.hpp"

#include <algorithm>
#include <cstring>

#include "gstcpp/frame_errors.hpp"
#include "gstcpp/memory_part.hpp"

namespace weir {

Result<StreamPlan> TextMedium::configure(const GstCaps* caps, const Wishes& wishes) {
  const char* format = gst_structure_get_string(gst_caps_get_structure(caps, 0), "format");
  if (!format || std::strcmp(format, "utf8") != 0)
    return Error{Code::FORMAT_UNSUPPORTED,
                 "this text format is no tensor",
                 format ? std::string("format=") + format : "no format",
                 "format=utf8",
                 "",
                 "text/x-raw,format=utf8 ! tensor_converter input-dim=300"};
  if (wishes.shapes.size() != 1)
    return Error{Code::OPTION_VALUE,
                 "the size of a text is not known",
                 std::to_string(wishes.shapes.size()) + " dimensions in input-dim",
                 "one: the bytes of each text",
                 "",
                 "tensor_converter input-dim=300"};
  const uint32_t size = wishes.shapes[0][0];
  StreamPlan plan;
  plan.spec.format = Format::Static;
  plan.spec.tensors = {{ElementType::UInt8, Shape{size, wishes.frames_per_tensor}, ""}};
  plan.spec.rate = rate_of(caps);
  plan.frame_bytes = frame_bytes_ = size;
  plan.frames_out = wishes.frames_per_tensor;
  cut_said_ = false;
  limit_ = wishes.limit;
  if (auto status = agree(plan.spec, wishes.tensors, "text"); !status) return status.error();
  return plan;
}

Result<MediumFrames> TextMedium::frames(gst::Ref<GstBuffer> buffer, Ledger* ledger) {
  const size_t size = gst_buffer_get_size(buffer.get());
  if (size < frame_bytes_) return padded(buffer.get(), size, ledger);
  if (size > frame_bytes_) return cut(buffer.get(), size);
  return MediumFrames{std::move(buffer), {}, {}};
}

Result<MediumFrames> TextMedium::padded(GstBuffer* buffer, size_t size, Ledger* ledger) const {
  if (auto status = limit_->check(frame_bytes_); !status) return status.error();
  auto allocated = gst::allocate_buffer(frame_bytes_);
  if (!allocated) return allocated.error();
  auto out = *std::move(allocated);
  gst_buffer_copy_into(out.get(), buffer, GST_BUFFER_COPY_METADATA, 0, static_cast<gsize>(-1));
  {
    const gst::Mapped to(out.get(), GST_MAP_WRITE);
    if (!to || gst_buffer_extract(buffer, 0, to.bytes().data(), size) != size)
      return gst::memory_not_mapped();
    std::ranges::fill(to.bytes().subspan(size), std::byte{0});
  }
  ledger->copied(size);
  return MediumFrames{std::move(out), {}, {}};
}

MediumFrames TextMedium::cut(GstBuffer* buffer, size_t size) {
  constexpr auto kParts = GstBufferCopyFlags(GST_BUFFER_COPY_METADATA | GST_BUFFER_COPY_MEMORY);
  MediumFrames out;
  out.buffer = gst::Ref<GstBuffer>::adopt(gst_buffer_copy_region(buffer, kParts, 0, frame_bytes_));
  // A region keeps no duration: it cannot know that the whole text's is meant.
  GST_BUFFER_DURATION(out.buffer.get()) = GST_BUFFER_DURATION(buffer);
  if (!std::exchange(cut_said_, true))
    out.warning = Error{Code::FRAME_SIZE,
                        "a text is longer than input-dim says and is cut, as others may be",
                        std::to_string(size) + " bytes",
                        std::to_string(frame_bytes_) + " bytes",
                        "",
                        "tensor_converter input-dim=" + std::to_string(size)};
  return out;
}

}  // namespace weir
