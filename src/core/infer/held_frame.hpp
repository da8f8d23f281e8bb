// What can hold the memory of the frame that this thread invokes (include/weir/hold_frame.h).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>

#include "weir/hold_frame.h"

namespace weir::infer {

class FrameOwner {
 public:
  // The memory of all inputs for as long as the object that is given; null where it cannot be.
  virtual std::shared_ptr<const void> hold() = 0;

 protected:
  ~FrameOwner() = default;
};

// While it lives, frames of this thread are held by `owner`.
class FrameOwnerScope {
 public:
  FrameOwnerScope(const weir_frame& frame, FrameOwner* owner) noexcept;
  FrameOwnerScope(const FrameOwnerScope&) = delete;
  FrameOwnerScope& operator=(const FrameOwnerScope&) = delete;
  ~FrameOwnerScope();

 private:
  const weir_frame* const frame_before_;
  FrameOwner* const owner_before_;
};

const weir_frame_holder& frame_holder() noexcept;

}  // namespace weir::infer
