// Wraps the memories of messages, checks them against the caps and packs those beyond the 15th.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/edgesrc/message_buffer.hpp"

#include <cstring>
#include <utility>

#include "core/tensor/packed_tensors.hpp"
#include "core/tensor/tensor_header.hpp"
#include "core/wire/peer_error.hpp"
#include "gstcpp/buffer/allocation.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"

namespace weir {
namespace {

using Memories = std::vector<gst::Ref<GstMemory>>;
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

size_t size_of(const gst::Ref<GstMemory>& memory) {
  return gst_memory_get_sizes(memory.get(), nullptr, nullptr);
}

// The tensors from the 16th on in one memory, as buffers have them.
Result<gst::Ref<GstMemory>> packed_memory(std::span<const gst::MappedMemory> rest,
                                          std::span<const TensorSpec> tensors, uint64_t* copied) {
  std::vector<uint64_t> sizes;
  size_t total = kPackedHeaderBytes;
  for (const auto& map : rest) {
    sizes.push_back(map.bytes().size());
    total += map.bytes().size();
  }
  auto out = gst::allocate_memory(total);
  if (!out) return out;
  const gst::MappedMemory map(out->get(), GST_MAP_WRITE);
  const auto bytes = map.bytes();
  write_packed_header(tensors, sizes, bytes.first<kPackedHeaderBytes>());
  size_t offset = kPackedHeaderBytes;
  for (const auto& part : rest) {
    std::memcpy(bytes.data() + offset, part.bytes().data(), part.bytes().size());
    offset += part.bytes().size();
    *copied += part.bytes().size();
  }
  return out;
}

Error unlike_caps(const Memories& memories, const std::string& needed) {
  std::string sizes;
  for (size_t i = 0; i < memories.size() && i < 16; ++i)
    sizes += (i ? "," : "") + std::to_string(size_of(memories[i]));
  return wire::peer_error("a frame does not match the caps of the stream",
                          std::to_string(memories.size()) + " memories of " + sizes + " bytes",
                          needed, "a capsfilter with the caps of the edgesink");
}

// Static tensors: the number and the sizes are those of the caps.
Status check(const Memories& memories, const std::vector<TensorSpec>& tensors) {
  if (tensors.size() != memories.size()) return ok();  // packed, or several tensors in a memory
  for (size_t i = 0; i < tensors.size(); ++i)
    if (tensors[i].bytes() != size_of(memories[i]))
      return unlike_caps(memories, tensors[i].to_string() + " as tensor " + std::to_string(i));
  return ok();
}

// What the headers of tensors declare.
Result<std::vector<TensorSpec>> read_headers(std::span<const gst::MappedMemory> maps) {
  std::vector<TensorSpec> out;
  for (const auto& map : maps) {
    auto header = read_tensor_chunk(map.bytes());
    if (!header) return header.error();
    if (kTensorHeaderBytes + *header->payload_bytes() != map.bytes().size())
      return wire::peer_error("a tensor does not have the size that its header declares",
                              std::to_string(map.bytes().size()) + " bytes",
                              std::to_string(kTensorHeaderBytes + *header->payload_bytes()) +
                                  " bytes for " + header->spec.to_string());
    out.push_back(std::move(header->spec));
  }
  return out;
}

}  // namespace

void MessageBuffers::set_caps(const GstCaps* caps) {
  const auto spec = gst::fixed_spec_from_caps(caps);
  tensors_ = spec && spec->format == Format::Static ? spec->tensors : std::vector<TensorSpec>();
  has_headers_ = spec && spec->format != Format::Static;
}

Result<gst::Ref<GstBuffer>> MessageBuffers::make(std::vector<wire::ByteBlock> blocks,
                                                 uint64_t* copied) const {
  Memories memories;
  for (auto& block : blocks)
    memories.push_back(gst::Ref<GstMemory>::adopt(memory_of(std::move(block))));
  return make(std::move(memories), copied);
}

Result<gst::Ref<GstBuffer>> MessageBuffers::make(Memories memories, uint64_t* copied) const {
  if (auto status = check(memories, tensors_); !status) return status.error();
  if (memories.size() > kMemoryLimit) {
    if (!has_headers_ && tensors_.size() != memories.size())
      return unlike_caps(memories, "at most 16 memories, or one for each tensor of the caps");
    const auto first = memories.begin() + (kMemoryLimit - 1);
    auto packed =
        pack({std::make_move_iterator(first), std::make_move_iterator(memories.end())}, copied);
    if (!packed) return packed.error();
    memories.erase(first, memories.end());
    memories.push_back(*std::move(packed));
  }
  auto out = gst::Ref<GstBuffer>::adopt(gst_buffer_new());
  for (auto& memory : memories) gst_buffer_append_memory(out.get(), memory.release());
  GST_BUFFER_FLAG_UNSET(out.get(), GST_BUFFER_FLAG_TAG_MEMORY);  // set by appending
  return out;
}

Result<gst::Ref<GstMemory>> MessageBuffers::pack(Memories rest, uint64_t* copied) const {
  std::vector<gst::MappedMemory> maps;
  for (const auto& memory : rest) maps.emplace_back(memory.get(), GST_MAP_READ);
  if (!has_headers_)
    return packed_memory(maps, std::span(tensors_).subspan(kMemoryLimit - 1), copied);
  const auto tensors = read_headers(maps);
  if (!tensors) return tensors.error();
  return packed_memory(maps, *tensors, copied);
}

}  // namespace weir
