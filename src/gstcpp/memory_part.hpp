// Parts of memories, and memories that cannot be mapped.
#pragma once
#include <gst/gst.h>

#include <cstddef>

#include "gstcpp/ref.hpp"
#include "weir/result.hpp"

namespace weir::gst {

// Shared where the memory allows that, else copied, which `copied` tells. All of it is the memory
// itself. Errors: MAP_FAILED, OUT_OF_MEMORY.
Result<Ref<GstMemory>> part_of(GstMemory* memory, size_t offset, size_t size, bool* copied);

// The memory of a buffer that has only one, otherwise a copy of all bytes in one memory.
// Errors: MAP_FAILED, OUT_OF_MEMORY.
Result<Ref<GstMemory>> one_memory(GstBuffer* buffer);

// Whether every memory of the buffer can be mapped for reading; tried where it is not the system's.
bool can_be_read(GstBuffer* buffer);
// Whether the buffer and its memories are ours alone and can be mapped for writing too.
bool can_be_written(GstBuffer* buffer);

}  // namespace weir::gst
