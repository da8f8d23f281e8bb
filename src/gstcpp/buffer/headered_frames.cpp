// Copies tensors into pooled buffers with a header for each.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/buffer/headered_frames.hpp"

#include "gstcpp/buffer/frame_errors.hpp"
#include "gstcpp/buffer/memory_part.hpp"

namespace weir::gst {

Result<Ref<GstBuffer>> HeaderedFrames::copy(GstBuffer* in, const std::vector<TensorSpec>& tensors,
                                            MediaType media, Ledger* ledger) {
  if (!pool_ || media != media_ || !first_difference(tensors, pool_.tensors()).empty()) {
    auto pool = FramePool::make(tensors, Format::Flexible, media);
    if (!pool) return pool.error();
    pool_ = *std::move(pool);
    media_ = media;
  }
  auto acquired = pool_.acquire();
  if (!acquired) return acquired;
  auto out = *std::move(acquired);
  FramePool::Writer writer;
  if (auto status = writer.map(pool_, out.get()); !status) return status.error();
  size_t offset = 0;
  for (const auto& payload : writer.payloads())
    offset += gst_buffer_extract(in, offset, payload.data(), payload.size());
  size_t needed = 0;
  for (const auto& payload : writer.payloads()) needed += payload.size();
  writer.unmap();
  if (offset != needed && !can_be_read(in)) return memory_not_mapped();
  if (offset != needed)
    return Error{.code = Code::FRAME_SIZE,
                 .what = "a frame is shorter than its tensors",
                 .offered = std::to_string(gst_buffer_get_size(in)) + " bytes",
                 .needed = std::to_string(needed) + " bytes"};
  ledger->copied(needed);
  gst_buffer_copy_into(out.get(), in, GST_BUFFER_COPY_METADATA, 0, static_cast<gsize>(-1));
  return out;
}

}  // namespace weir::gst
