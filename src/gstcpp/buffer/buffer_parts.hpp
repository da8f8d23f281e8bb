// Puts the parts of one frame into a buffer without exceeding the memories that a buffer can hold.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <cstddef>
#include <functional>
#include <span>

#include "gstcpp/element/ref.hpp"
#include "weir/result.hpp"

namespace weir::gst {

struct BufferPart {
  Ref<GstMemory> memory;             // must no longer be mapped for writing
  std::span<const std::byte> bytes;  // copied when there is no memory
};

// Allocates the memory into which bytes are copied.
using AllocateBytes = std::function<Result<Ref<GstMemory>>(size_t bytes)>;

// Appends the parts in order, one memory each. Of more than 16 parts, the 16th and all later ones
// share one memory: GStreamer would otherwise merge, and therefore map, memories automatically.
// Errors: MAPPING_FAILED, those of `allocate`. Precondition: `out` has no memory.
Status append_parts(std::span<const BufferPart> parts, GstBuffer* out,
                    const AllocateBytes& allocate);

}  // namespace weir::gst
