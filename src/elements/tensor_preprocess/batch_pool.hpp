// BatchPool: buffers for batches of one tensor whose number changes from frame to frame.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "gstcpp/frame_pool.hpp"

namespace weir {

// A flexible buffer has room for a power of two of parts and is cut to those that are used: the
// pool changes when more are needed, or far fewer for many frames.
class BatchPool {
 public:
  BatchPool() = default;
  // `part`: of which dimension 3 counts the parts. `most`: of a static tensor; 0 = flexible.
  // LIMIT_EXCEEDED.
  static Result<BatchPool> make(const TensorSpec& part, uint32_t most);
  Status allocate_as(const gst::Allocation& allocation);

  // A buffer of one memory for `parts` parts (static: `most`), its header written. Precondition:
  // parts is above 0 and, where static, at most `most`. OUT_OF_MEMORY, LIMIT_EXCEEDED.
  Result<gst::Ref<GstBuffer>> acquire(size_t parts, const BufferLimit& limit);
  uint64_t allocated() const { return allocated_before_ + pool_.stats().allocated; }

 private:
  Status renew(size_t room);
  size_t retained(size_t room) const;
  TensorSpec batch_of(size_t parts) const;

  TensorSpec part_;
  uint32_t most_ = 0;
  size_t room_ = 0;            // parts of each buffer
  uint32_t small_frames_ = 0;  // in a row
  gst::Allocation allocation_;
  gst::FramePool pool_;
  uint64_t allocated_before_ = 0;  // by pools that are no more
};

}  // namespace weir
