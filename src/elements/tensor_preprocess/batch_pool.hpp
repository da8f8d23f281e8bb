// BatchPool: buffers for batches of one tensor whose number changes from frame to frame.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "gstcpp/buffer/frame_pool.hpp"

namespace weir {

// A flexible buffer has room for a power of two of parts and is shortened to those in use. The pool
// is remade when more are needed, or when many frames in a row need far fewer.
class BatchPool {
 public:
  BatchPool() = default;
  // `part`: its dimension 3 counts the parts. `max`: parts of a static tensor; 0 = flexible.
  // LIMIT_EXCEEDED.
  static Result<BatchPool> make(const TensorSpec& part, uint32_t max);
  Status allocate_as(const gst::Allocation& allocation);

  // A buffer of one memory for `parts` parts (static: `max`), with its header. Precondition: parts
  // is above 0 and, if static, at most `max`. OUT_OF_MEMORY, LIMIT_EXCEEDED.
  Result<gst::Ref<GstBuffer>> acquire(size_t parts, const BufferLimit& limit);
  uint64_t allocated() const { return allocated_before_ + pool_.stats().allocated; }

 private:
  Status renew(size_t room);
  size_t retained(size_t room) const;
  TensorSpec make_batch(size_t parts) const;

  TensorSpec part_;
  uint32_t max_ = 0;
  size_t room_ = 0;            // parts of each buffer
  uint32_t small_frames_ = 0;  // consecutive
  gst::Allocation allocation_;
  gst::FramePool pool_;
  uint64_t allocated_before_ = 0;  // by previous pools
};

}  // namespace weir
