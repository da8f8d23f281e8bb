// BufferCopies: copies of buffers that others hold too, in memory that is used again.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include "gstcpp/frame_pool.hpp"
#include "weir/result.hpp"

namespace weir {

class BufferCopies {
 public:
  // All bytes in one memory, with times, flags and metadata. OUT_OF_MEMORY, MAP_FAILED.
  Result<gst::Ref<GstBuffer>> copy_of(GstBuffer* buffer);
  void clear() { pool_ = {}; }

 private:
  Status set_size(size_t bytes);

  gst::FramePool pool_;
  size_t bytes_ = 0;  // of a buffer of the pool
};

}  // namespace weir
