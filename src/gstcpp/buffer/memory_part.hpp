// Parts of memories and of buffers, and whether the memories of a buffer can be mapped.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <cstddef>
#include <cstdint>

#include "gstcpp/element/ref.hpp"
#include "weir/result.hpp"

namespace weir::gst {

// Shares the part if the memory allows it, otherwise copies it and adds its bytes to `copied`. The
// whole range returns the memory itself. Errors: MAPPING_FAILED, OUT_OF_MEMORY.
Result<Ref<GstMemory>> make_part(GstMemory* memory, size_t offset, size_t size, uint64_t* copied);

// The same for bytes of a buffer, which may span several memories: then they are copied, and so
// is a whole memory that cannot be shared.
Result<Ref<GstMemory>> share_bytes(GstBuffer* buffer, size_t offset, size_t size, uint64_t* copied);

// Returns the memory of a buffer that has only one, otherwise a copy of all bytes in one memory.
// Errors: MAPPING_FAILED, OUT_OF_MEMORY.
Result<Ref<GstMemory>> one_memory(GstBuffer* buffer);

// Whether every memory can be mapped for reading; memory other than system memory is tried.
bool can_be_read(GstBuffer* buffer);
// Whether the buffer and its memories are writable and can also be mapped for writing.
bool can_be_written(GstBuffer* buffer);

}  // namespace weir::gst
