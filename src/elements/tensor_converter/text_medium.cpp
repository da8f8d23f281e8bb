// Converts text to tensors (docs/compatibility/converter.md 2.3).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_converter/text_medium.hpp"

#include <algorithm>
#include <cstring>

#include "gstcpp/buffer/frame_errors.hpp"
#include "gstcpp/buffer/memory_part.hpp"

namespace weir {

Result<StreamPlan> TextMedium::configure(const GstCaps* caps, const Preferences& preferences) {
  const char* format = gst_structure_get_string(gst_caps_get_structure(caps, 0), "format");
  if (!format || std::strcmp(format, "utf8") != 0)
    return Error{.code = Code::FORMAT_UNSUPPORTED,
                 .what = "this text format cannot be a tensor",
                 .offered = format ? std::string("format=") + format : "no format",
                 .needed = "format=utf8",
                 .fix = "text/x-raw,format=utf8 ! tensor_converter input-dim=300"};
  if (preferences.shapes.size() != 1)
    return Error{.code = Code::OPTION_VALUE,
                 .what = "the size of a text is unknown",
                 .offered = std::to_string(preferences.shapes.size()) + " dimensions in input-dim",
                 .needed = "one: the bytes of each text",
                 .fix = "tensor_converter input-dim=300"};
  const uint32_t size = preferences.shapes[0][0];
  StreamPlan plan;
  plan.spec.format = Format::Static;
  plan.spec.tensors = {{ElementType::UInt8, Shape{size, preferences.frames_per_tensor}, ""}};
  plan.spec.rate = rate_of(caps);
  plan.frame_bytes = frame_bytes_ = size;
  plan.frames_out = preferences.frames_per_tensor;
  cut_reported_ = false;
  limit_ = preferences.limit;
  if (auto status = agree(plan.spec, preferences.tensors, "text"); !status) return status.error();
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
  // A region of a buffer loses the duration; the text has the duration of the whole.
  GST_BUFFER_DURATION(out.buffer.get()) = GST_BUFFER_DURATION(buffer);
  if (!std::exchange(cut_reported_, true))
    out.warning = Error{.code = Code::FRAME_SIZE,
                        .what =
                            "a text is longer than input-dim and is truncated; later ones are "
                            "truncated without a warning",
                        .offered = std::to_string(size) + " bytes",
                        .needed = std::to_string(frame_bytes_) + " bytes",
                        .fix = "tensor_converter input-dim=" + std::to_string(size)};
  return out;
}

}  // namespace weir
