// BufferCopies: writable copies of shared buffers, in pooled memory.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include "gstcpp/buffer/frame_pool.hpp"
#include "weir/result.hpp"

namespace weir {

class BufferCopies {
 public:
  // Copies all bytes into one memory, with times, flags and metas. OUT_OF_MEMORY, MAPPING_FAILED.
  Result<gst::Ref<GstBuffer>> copy_of(GstBuffer* buffer);
  void clear() { pool_ = {}; }

 private:
  Status set_size(size_t bytes);

  gst::FramePool pool_;
  size_t bytes_ = 0;  // size of the pool's buffers
};

}  // namespace weir
