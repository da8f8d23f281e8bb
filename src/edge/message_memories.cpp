// SPDX-License-Identifier: LGPL-2.1-or-later
#include "edge/message_memories.hpp"

#include <utility>

#include "gstcpp/buffer/tensor_caps.hpp"
#include "gstcpp/element/ref.hpp"

namespace weir {
namespace {

// What a message keeps until it is sent.
struct MappedBuffer {
  gst::Ref<GstBuffer> buffer;
  std::vector<gst::MappedMemory> maps;  // unmapped before the buffer is released
};

// The bytes of a tensor with its header; empty if it does not lie in one memory.
std::span<const std::byte> get_bytes(const std::vector<gst::MappedMemory>& maps,
                                     const gst::TensorPlace& place) {
  size_t start = 0;
  for (const auto& map : maps) {
    const size_t size = map.bytes().size();
    if (place.offset >= start && place.offset < start + size)
      return place.size <= start + size - place.offset
                 ? map.bytes().subspan(place.offset - start, place.size)
                 : std::span<std::byte>();
    start += size;
  }
  return {};
}

Error not_in_one_memory() {
  return Error{.code = Code::FRAME_SIZE,
               .what = "a tensor of the buffer lies in several memories",
               .needed = "tensors that lie in one memory each",
               .fix = "put an element that writes new tensors upstream, such as tensor_transform"};
}

}  // namespace

void MemoryMapper::set_caps(const GstCaps* caps) {
  const auto spec = gst::spec_from_caps(caps);
  has_tensors_ = spec.has_value();
  if (spec) spec_ = *spec;
}

Result<MessageMemories> MemoryMapper::map(GstBuffer* buffer) {
  auto owner = std::make_shared<MappedBuffer>();
  owner->buffer = gst::Ref<GstBuffer>::share(buffer);
  MessageMemories out;
  for (guint i = 0; i < gst_buffer_n_memory(buffer); ++i) {
    owner->maps.emplace_back(gst_buffer_peek_memory(buffer, i), GST_MAP_READ);
    if (!owner->maps.back())
      return Error{.code = Code::MAPPING_FAILED,
                   .what = "a memory of the buffer cannot be mapped for reading",
                   .needed = "memory that the CPU can read"};
    out.memories.emplace_back(owner->maps.back().bytes());
  }
  if (has_tensors_) {
    if (auto status = layout_.locate(buffer, spec_); !status) return status.error();
    out.memories.clear();
    for (const auto& place : layout_.tensors()) {
      out.memories.push_back(get_bytes(owner->maps, place));
      if (out.memories.back().size() != place.size) return not_in_one_memory();
    }
  }
  out.owner = std::move(owner);
  return out;
}

}  // namespace weir
