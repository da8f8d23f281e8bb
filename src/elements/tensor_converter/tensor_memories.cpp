// Shares or copies the payloads of tensors.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_converter/tensor_memories.hpp"

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
    bool copied = false;
    auto part = gst::part_of(all->get(), offset, size, &copied);
    if (!part) return part.error();
    if (copied) ledger->copied(size);
    gst_buffer_append_memory(out.get(), part->release());
    offset += size;
  }
  return out;
}

}  // namespace weir
