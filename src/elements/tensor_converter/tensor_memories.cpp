// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_converter/tensor_memories.hpp"

#include "gstcpp/buffer/frame_errors.hpp"
#include "gstcpp/buffer/memory_part.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"

namespace weir {
namespace {

bool is_dense(GstBuffer* buffer, const std::vector<TensorSpec>& tensors) {
  const size_t count = tensors.size() > kMemoryLimit ? 1 : tensors.size();
  if (gst_buffer_n_memory(buffer) != count) return false;
  if (count == 1) return true;
  for (guint i = 0; i < count; ++i)
    if (gst_memory_get_sizes(gst_buffer_peek_memory(buffer, i), nullptr, nullptr) !=
        tensors[i].bytes())
      return false;
  return true;
}

}  // namespace

Result<gst::Ref<GstBuffer>> one_memory_each(gst::Ref<GstBuffer> in,
                                            const std::vector<TensorSpec>& tensors,
                                            Ledger* ledger) {
  if (is_dense(in.get(), tensors)) return in;
  if (gst_buffer_n_memory(in.get()) > 1) ledger->copied(gst_buffer_get_size(in.get()));
  auto out = gst::Ref<GstBuffer>::adopt(gst_buffer_new());
  gst_buffer_copy_into(out.get(), in.get(), GST_BUFFER_COPY_METADATA, 0, static_cast<gsize>(-1));
  auto all = gst::one_memory(in.get());
  if (!all) return all.error();
  if (tensors.size() == 1 || tensors.size() > kMemoryLimit) {
    gst_buffer_append_memory(out.get(), all->release());
    return out;
  }
  size_t offset = 0;
  for (const auto& tensor : tensors) {
    const auto size = static_cast<size_t>(*tensor.bytes());
    uint64_t copied = 0;
    auto part = gst::make_part(all->get(), offset, size, &copied);
    if (!part) return part.error();
    if (copied > 0) ledger->copied(copied);
    gst_buffer_append_memory(out.get(), part->release());
    offset += size;
  }
  return out;
}

Result<gst::Ref<GstBuffer>> HeaderedFrames::copy(GstBuffer* in,
                                                 const std::vector<TensorSpec>& tensors,
                                                 MediaType media, Ledger* ledger) {
  if (!pool_ || media != media_ || !first_difference(tensors, pool_.tensors()).empty()) {
    auto pool = gst::FramePool::make(tensors, Format::Flexible, media);
    if (!pool) return pool.error();
    pool_ = *std::move(pool);
    media_ = media;
  }
  auto acquired = pool_.acquire();
  if (!acquired) return acquired;
  auto out = *std::move(acquired);
  gst::FramePool::Writer writer;
  if (auto status = writer.map(pool_, out.get()); !status) return status.error();
  size_t offset = 0, needed = 0;
  for (const auto& payload : writer.payloads()) {
    offset += gst_buffer_extract(in, offset, payload.data(), payload.size());
    needed += payload.size();
  }
  writer.unmap();
  if (offset != needed && !gst::can_be_read(in)) return gst::memory_not_mapped();
  if (offset != needed)
    return gst::wrong_frame_size({Format::Static, tensors, {}}, in, "the buffer is too small");
  ledger->copied(needed);
  gst_buffer_copy_into(out.get(), in, GST_BUFFER_COPY_METADATA, 0, static_cast<gsize>(-1));
  return out;
}

}  // namespace weir
