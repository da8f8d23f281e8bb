// Buffers that share the memories of other buffers.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <span>

#include "gstcpp/element/ref.hpp"

namespace weir::gst {

// Makes an empty buffer for memories of `owners` or parts of them. Owners from a pool are held
// until the buffer has dropped its memories: a pool discards a returned buffer whose memory is
// still in use and would allocate for each frame. GstParentBufferMeta releases the owner too early
// for that; also unlike it, this reference is not copied with metadata.
Ref<GstBuffer> sharing_buffer(std::span<GstBuffer* const> owners);

}  // namespace weir::gst
