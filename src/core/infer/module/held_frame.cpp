// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/infer/module/held_frame.hpp"

#include <memory>
#include <new>

namespace weir::infer {
namespace {

thread_local const weir_frame* frame = nullptr;
thread_local FrameOwner* owner = nullptr;

using Hold = std::shared_ptr<const void>;

int hold(const weir_frame* in, void (**release)(void*), void** kept) {
  if (!owner || in != frame || !release || !kept) return -WEIR_MAPPING_FAILED;
  try {
    auto held = owner->hold();
    if (!held) return -WEIR_MAPPING_FAILED;
    *kept = std::make_unique<Hold>(std::move(held)).release();
    *release = [](void* given) { delete static_cast<Hold*>(given); };
    return WEIR_OK;
  } catch (const std::bad_alloc&) {
    return -WEIR_OUT_OF_MEMORY;
  }
}

constexpr weir_frame_holder kHolder{sizeof(weir_frame_holder), hold};

}  // namespace

FrameOwnerScope::FrameOwnerScope(const weir_frame& in, FrameOwner* holder) noexcept
    : frame_before_(frame), owner_before_(owner) {
  frame = &in;
  owner = holder;
}

FrameOwnerScope::~FrameOwnerScope() {
  frame = frame_before_;
  owner = owner_before_;
}

const weir_frame_holder& frame_holder() noexcept {
  return kHolder;
}

}  // namespace weir::infer
