// Appends the parts of a frame to a buffer; merges those beyond its last memory into one.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/buffer/buffer_parts.hpp"

#include <cstring>

#include "core/tensor/packed_tensors.hpp"
#include "gstcpp/buffer/frame_errors.hpp"

namespace weir::gst {
namespace {

size_t size_of(const BufferPart& part) {
  return part.memory ? gst_memory_get_sizes(part.memory.get(), nullptr, nullptr)
                     : part.bytes.size();
}

Status copy(const BufferPart& part, std::span<std::byte> out) {
  MappedMemory map;
  if (part.memory) map = MappedMemory(part.memory.get(), GST_MAP_READ);
  if (part.memory && !map) return memory_not_mapped();
  const std::span<const std::byte> from = part.memory ? map.bytes() : part.bytes;
  if (!from.empty()) std::memcpy(out.data(), from.data(), from.size());
  return ok();
}

// Copies the parts into one memory.
Result<Ref<GstMemory>> joined(std::span<const BufferPart> parts, const AllocateBytes& allocate) {
  size_t total = 0;
  for (const auto& part : parts) total += size_of(part);
  auto memory = allocate(total);
  if (!memory) return memory;
  const MappedMemory map(memory->get(), GST_MAP_WRITE);
  if (!map) return memory_not_mapped();
  size_t at = 0;
  for (const auto& part : parts) {
    if (auto status = copy(part, map.bytes().subspan(at)); !status) return status.error();
    at += size_of(part);
  }
  return memory;
}

}  // namespace

Status append_parts(std::span<const BufferPart> parts, GstBuffer* out,
                    const AllocateBytes& allocate) {
  const size_t alone = parts.size() > kMemoryLimit ? kMemoryLimit - 1 : parts.size();
  const auto append = [&](std::span<const BufferPart> some) -> Status {
    auto one = some.size() == 1 && some[0].memory ? Result(some[0].memory) : joined(some, allocate);
    if (!one) return one.error();
    gst_buffer_append_memory(out, one->release());
    return ok();
  };
  for (size_t i = 0; i < alone; ++i)
    if (auto status = append(parts.subspan(i, 1)); !status) return status;
  return alone < parts.size() ? append(parts.subspan(alone)) : ok();
}

}  // namespace weir::gst
