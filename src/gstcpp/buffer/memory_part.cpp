// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/buffer/memory_part.hpp"

#include <cstring>

#include "gstcpp/buffer/allocation.hpp"
#include "gstcpp/buffer/frame_errors.hpp"
#include "gstcpp/element/ref.hpp"

namespace weir::gst {

namespace {

// Copies bytes of a buffer into one memory.
Result<Ref<GstMemory>> copy_bytes(GstBuffer* buffer, size_t offset, size_t size) {
  auto copy = allocate_memory(size);
  if (!copy) return copy;
  const MappedMemory map(copy->get(), GST_MAP_WRITE);
  if (!map) return memory_ran_out(size);
  if (gst_buffer_extract(buffer, offset, map.bytes().data(), size) != size)
    return memory_not_mapped();
  return copy;
}

}  // namespace

Result<Ref<GstMemory>> make_part(GstMemory* memory, size_t offset, size_t size, uint64_t* copied) {
  if (offset == 0 && size == gst_memory_get_sizes(memory, nullptr, nullptr))
    return Ref<GstMemory>::share(memory);
  const auto from = static_cast<gssize>(offset), length = static_cast<gssize>(size);
  if (!GST_MEMORY_IS_NO_SHARE(memory))
    if (GstMemory* shared = gst_memory_share(memory, from, length))
      return Ref<GstMemory>::adopt(shared);
  const MappedMemory source(memory, GST_MAP_READ);
  if (!source) return memory_not_mapped();
  auto copy = allocate_memory(size);
  if (!copy) return copy;
  const MappedMemory target(copy->get(), GST_MAP_WRITE);
  if (!target) return memory_ran_out(size);
  std::memcpy(target.bytes().data(), source.bytes().subspan(offset, size).data(), size);
  *copied += size;
  return copy;
}

Result<Ref<GstMemory>> share_bytes(GstBuffer* buffer, size_t offset, size_t size,
                                   uint64_t* copied) {
  guint index = 0, length = 0;
  gsize skip = 0;
  if (!gst_buffer_find_memory(buffer, offset, size, &index, &length, &skip))
    return memory_not_mapped();
  GstMemory* const memory = gst_buffer_peek_memory(buffer, index);
  if (length == 1 && !GST_MEMORY_IS_NO_SHARE(memory)) return make_part(memory, skip, size, copied);
  auto copy = copy_bytes(buffer, offset, size);
  if (copy) *copied += size;
  return copy;
}

Result<Ref<GstMemory>> one_memory(GstBuffer* buffer) {
  if (gst_buffer_n_memory(buffer) == 1)
    return Ref<GstMemory>::share(gst_buffer_peek_memory(buffer, 0));
  return copy_bytes(buffer, 0, gst_buffer_get_size(buffer));
}

namespace {

bool can_be_mapped(GstBuffer* buffer, GstMapFlags flags) {
  for (guint i = 0; i < gst_buffer_n_memory(buffer); ++i) {
    GstMemory* memory = gst_buffer_peek_memory(buffer, i);
    if ((flags & GST_MAP_WRITE) && GST_MEMORY_IS_READONLY(memory)) return false;
    if (!gst_memory_is_type(memory, GST_ALLOCATOR_SYSMEM) && !MappedMemory(memory, flags))
      return false;
  }
  return true;
}

}  // namespace

bool can_be_read(GstBuffer* buffer) {
  return can_be_mapped(buffer, GST_MAP_READ);
}

bool can_be_written(GstBuffer* buffer) {
  return gst_buffer_is_writable(buffer) && gst_buffer_is_all_memory_writable(buffer) &&
         can_be_mapped(buffer, GST_MAP_READWRITE);
}

}  // namespace weir::gst
