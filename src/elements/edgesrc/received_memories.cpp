// Checks memories against the caps and packs those beyond the 15th.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/edgesrc/received_memories.hpp"

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

void BufferAssembler::set_caps(const GstCaps* caps) {
  const auto spec = gst::fixed_spec_from_caps(caps);
  tensors_ = spec && spec->format == Format::Static ? spec->tensors : std::vector<TensorSpec>();
  has_headers_ = spec && spec->format != Format::Static;
}

Result<InputEvent> BufferAssembler::assemble(Memories memories) const {
  if (auto status = check(memories, tensors_); !status) return status.error();
  InputEvent out{InputEvent::Kind::Buffer, {}, gst::Ref<GstBuffer>::adopt(gst_buffer_new())};
  GstBuffer* const buffer = out.buffer.get();
  gst::Ref<GstMemory> packed;
  size_t alone = memories.size();
  if (memories.size() > kMemoryLimit) {
    if (!has_headers_ && tensors_.size() != memories.size())
      return unlike_caps(memories, "at most 16 memories, or one for each tensor of the caps");
    alone = kMemoryLimit - 1;
    std::vector<gst::MappedMemory> rest;
    for (size_t i = alone; i < memories.size(); ++i)
      rest.emplace_back(memories[i].get(), GST_MAP_READ);
    auto tensors = has_headers_
                       ? read_headers(rest)
                       : Result<std::vector<TensorSpec>>(std::vector<TensorSpec>(
                             tensors_.begin() + static_cast<ptrdiff_t>(alone), tensors_.end()));
    if (!tensors) return tensors.error();
    auto made = packed_memory(rest, *tensors, &out.copied);
    if (!made) return made.error();
    packed = *std::move(made);
  }
  for (size_t i = 0; i < alone; ++i) gst_buffer_append_memory(buffer, memories[i].release());
  if (packed) gst_buffer_append_memory(buffer, packed.release());
  GST_BUFFER_FLAG_UNSET(buffer, GST_BUFFER_FLAG_TAG_MEMORY);  // set by appending
  return out;
}

}  // namespace weir
