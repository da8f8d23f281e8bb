// Parts of memories, and memories that cannot be mapped.
#pragma once
#include <gst/gst.h>

#include <cstddef>

#include "gstcpp/ref.hpp"
#include "weir/result.hpp"

namespace weir::gst {

// Shared where the memory allows that, else copied, which `copied` tells. All of it is the memory
// itself. The caller owns the result; null when it can neither be shared nor be mapped.
GstMemory* part_of(GstMemory* memory, size_t offset, size_t size, bool* copied);

// A copy of all bytes of the buffer in one memory. Errors: MAP_FAILED, OUT_OF_MEMORY.
Result<Ref<GstMemory>> merged_memory(GstBuffer* buffer);

// Whether every memory of the buffer can be mapped for reading; tried where it is not the system's.
bool can_be_read(GstBuffer* buffer);
// Whether the buffer and its memories are ours alone and can be mapped for writing too.
bool can_be_written(GstBuffer* buffer);
// Why nothing could be made of the buffer's bytes: MAP_FAILED when they cannot be read, else
// OUT_OF_MEMORY.
Error why_no_memory(GstBuffer* buffer);

}  // namespace weir::gst
