// Parts of one frame, put into a buffer of as many memories as a buffer can have.
#pragma once
#include <gst/gst.h>

#include <cstddef>
#include <functional>
#include <span>

#include "gstcpp/ref.hpp"
#include "weir/result.hpp"

namespace weir::gst {

struct BufferPart {
  Ref<GstMemory> memory;             // not mapped for writing any more
  std::span<const std::byte> bytes;  // to be copied, where there is no memory
};

// Called for memory that bytes are copied into.
using AllocateBytes = std::function<Result<Ref<GstMemory>>(size_t bytes)>;

// Appends the parts in their order: a memory for each, from the 16th on one for all where there are
// more than 16. GStreamer joins memories by itself when a buffer gets more than it can have, and
// maps them for that. Errors: MAP_FAILED, those of `allocate`. Precondition: `out` has no memory.
Status append_parts(std::span<const BufferPart> parts, GstBuffer* out,
                    const AllocateBytes& allocate);

}  // namespace weir::gst
