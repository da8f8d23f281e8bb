// Wraps the memories of messages.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/edgesrc/message_buffer.hpp"

#include <cstring>
#include <utility>

#include "core/tensor/packed_tensors.hpp"
#include "core/wire/peer_error.hpp"
#include "gstcpp/buffer/allocation.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"

namespace weir {
namespace {

using Bytes = std::unique_ptr<std::byte[]>;

void free_bytes(gpointer bytes) {
  const std::unique_ptr<Bytes> owned(static_cast<Bytes*>(bytes));
}

GstMemory* memory_of(wire::ByteBlock block) {
  auto owner = std::make_unique<Bytes>(std::move(block.data));
  std::byte* const data = owner->get();
  return gst_memory_new_wrapped(GstMemoryFlags(0), data, block.size, 0, block.size, owner.release(),
                                free_bytes);
}

// The tensors from the 16th on in one memory, as buffers have them.
Result<gst::Ref<GstMemory>> packed_memory(std::span<const wire::ByteBlock> rest,
                                          std::span<const TensorSpec> tensors, uint64_t* copied) {
  std::vector<uint64_t> sizes;
  size_t total = kPackedHeaderBytes;
  for (const auto& block : rest) {
    sizes.push_back(block.size);
    total += block.size;
  }
  auto out = gst::allocate_memory(total);
  if (!out) return out;
  const gst::MappedMemory map(out->get(), GST_MAP_WRITE);
  const auto bytes = map.bytes();
  write_packed_header(tensors, sizes, bytes.first<kPackedHeaderBytes>());
  size_t offset = kPackedHeaderBytes;
  for (const auto& block : rest) {
    std::memcpy(bytes.data() + offset, block.data.get(), block.size);
    offset += block.size;
    *copied += block.size;
  }
  return out;
}

Error unlike_caps(const std::vector<wire::ByteBlock>& memories, const std::string& needed) {
  std::string sizes;
  for (size_t i = 0; i < memories.size() && i < 16; ++i)
    sizes += (i ? "," : "") + std::to_string(memories[i].size);
  return wire::peer_error("a frame does not match the caps of the stream",
                          std::to_string(memories.size()) + " memories of " + sizes + " bytes",
                          needed, "a capsfilter with the caps of the edgesink");
}

// Static tensors: the number and the sizes are those of the caps.
Status check(const std::vector<wire::ByteBlock>& memories, const std::vector<TensorSpec>& tensors) {
  if (memories.size() > kMemoryLimit && tensors.size() != memories.size())
    return unlike_caps(memories, "at most 16 memories, or one for each tensor of static caps");
  if (tensors.size() != memories.size()) return ok();  // packed, or several tensors in a memory
  for (size_t i = 0; i < tensors.size(); ++i)
    if (tensors[i].bytes() != memories[i].size)
      return unlike_caps(memories, tensors[i].to_string() + " as tensor " + std::to_string(i));
  return ok();
}

}  // namespace

void MessageBuffers::set_caps(const GstCaps* caps) {
  const auto spec = gst::fixed_spec_from_caps(caps);
  tensors_ = spec && spec->format == Format::Static ? spec->tensors : std::vector<TensorSpec>();
}

Result<gst::Ref<GstBuffer>> MessageBuffers::make(std::vector<wire::ByteBlock> memories,
                                                 uint64_t* copied) const {
  if (auto status = check(memories, tensors_); !status) return status.error();
  auto buffer = gst::Ref<GstBuffer>::adopt(gst_buffer_new());
  const size_t alone = memories.size() > kMemoryLimit ? kMemoryLimit - 1 : memories.size();
  for (size_t i = 0; i < alone; ++i)
    gst_buffer_append_memory(buffer.get(), memory_of(std::move(memories[i])));
  if (alone < memories.size()) {
    auto packed = packed_memory(std::span(memories).subspan(alone),
                                std::span(tensors_).subspan(alone), copied);
    if (!packed) return packed.error();
    gst_buffer_append_memory(buffer.get(), packed->release());
  }
  GST_BUFFER_FLAG_UNSET(buffer.get(), GST_BUFFER_FLAG_TAG_MEMORY);  // set by appending
  return buffer;
}

}  // namespace weir
