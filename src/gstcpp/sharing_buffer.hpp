// Buffers whose memories are those of other buffers.
#pragma once
#include <gst/gst.h>

#include <span>

#include "gstcpp/ref.hpp"

namespace weir::gst {

// An empty buffer for memories of `owners`, or parts of them. Owners that come from a pool are held
// until the buffer has let its memories go: a pool throws away what comes back while its memory is
// still in use, and has to allocate anew for each frame. Unlike GstParentBufferMeta, which lets the
// owner go too early for that, this is not copied with metadata.
Ref<GstBuffer> sharing_buffer(std::span<GstBuffer* const> owners);

}  // namespace weir::gst
