// SPDX-License-Identifier: LGPL-2.1-or-later
#include "edge/message_buffer.hpp"

#include <utility>

#include "core/tensor/tensor_header.hpp"
#include "core/wire/peer_error.hpp"
#include "gstcpp/buffer/frame_builder.hpp"
#include "gstcpp/buffer/tensor_caps.hpp"

namespace weir {
namespace {

using Memories = std::vector<gst::Ref<GstMemory>>;
using Bytes = std::unique_ptr<std::byte[]>;

void free_bytes(gpointer bytes) {
  const std::unique_ptr<Bytes> owned(static_cast<Bytes*>(bytes));
}

GstMemory* wrap_memory(wire::ByteBlock block) {
  auto owner = std::make_unique<Bytes>(std::move(block.data));
  std::byte* const data = owner->get();
  return gst_memory_new_wrapped(GstMemoryFlags(0), data, block.size, 0, block.size, owner.release(),
                                free_bytes);
}

size_t get_size(const gst::Ref<GstMemory>& memory) {
  return gst_memory_get_sizes(memory.get(), nullptr, nullptr);
}

Error unlike_caps(const Memories& memories, const std::string& needed,
                  const std::vector<TensorSpec>& tensors) {
  std::string sizes;
  for (size_t i = 0; i < memories.size() && i < 16; ++i)
    sizes += (i ? "," : "") + std::to_string(get_size(memories[i]));
  return wire::peer_error("a frame does not match the caps of the stream",
                          std::to_string(memories.size()) + " memories of " + sizes + " bytes",
                          needed + "; the fix is a capsfilter before the element that sends them",
                          gst::caps_to_paste({Format::Static, tensors, {}}));
}

// Static tensors: the number and the sizes are those of the caps.
Status check(const Memories& memories, const std::vector<TensorSpec>& tensors) {
  if (tensors.size() != memories.size()) return ok();  // packed, or several tensors in a memory
  for (size_t i = 0; i < tensors.size(); ++i)
    if (tensors[i].bytes() != get_size(memories[i]))
      return unlike_caps(memories, tensors[i].to_string() + " as tensor " + std::to_string(i),
                         tensors);
  return ok();
}

// What the header of a tensor declares.
Result<TensorSpec> read_header(GstMemory* memory) {
  const gst::MappedMemory map(memory, GST_MAP_READ);
  auto header = read_tensor_chunk(map.bytes());
  if (!header) return header.error();
  if (kTensorHeaderBytes + *header->payload_bytes() != map.bytes().size())
    return wire::peer_error("a tensor does not have the size that its header declares",
                            std::to_string(map.bytes().size()) + " bytes",
                            std::to_string(kTensorHeaderBytes + *header->payload_bytes()) +
                                " bytes for " + header->spec.to_string());
  return std::move(header->spec);
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
    memories.push_back(gst::Ref<GstMemory>::adopt(wrap_memory(std::move(block))));
  return make(std::move(memories), copied);
}

Result<gst::Ref<GstBuffer>> MessageBuffers::make(Memories memories, uint64_t* copied) const {
  if (auto status = check(memories, tensors_); !status) return status.error();
  auto out = gst::Ref<GstBuffer>::adopt(gst_buffer_new());
  if (memories.size() > kMemoryLimit) {
    if (auto status = pack(std::move(memories), out.get(), copied); !status) return status.error();
  } else {
    for (auto& memory : memories) gst_buffer_append_memory(out.get(), memory.release());
  }
  GST_BUFFER_FLAG_UNSET(out.get(), GST_BUFFER_FLAG_TAG_MEMORY);  // set by appending
  return out;
}

Status MessageBuffers::pack(Memories memories, GstBuffer* out, uint64_t* copied) const {
  if (!has_headers_ && tensors_.size() != memories.size())
    return unlike_caps(memories, "at most 16 memories, or one for each tensor of the caps",
                       tensors_);
  std::vector<gst::TensorPiece> pieces;
  for (auto& memory : memories) {
    const size_t i = pieces.size();
    TensorSpec spec;
    if (!has_headers_) {
      spec = tensors_[i];
    } else if (i + 1 >= kMemoryLimit) {
      auto header = read_header(memory.get());
      if (!header) return header.error();
      spec = *std::move(header);
    }
    pieces.push_back({std::move(memory), std::move(spec)});
  }
  return gst::append_tensors(pieces, out, copied);
}

}  // namespace weir
