// Extends the lifetime of the frame that a thread is invoking (weir_frame_holder).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>

#include "weir/abi.h"

namespace weir::infer {

class FrameOwner {
 public:
  // Keeps the memory of all inputs valid as long as the returned object; null if impossible.
  virtual std::shared_ptr<const void> hold() = 0;

 protected:
  ~FrameOwner() = default;
};

// Sets the owner of this thread's frame for the lifetime of the object.
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
