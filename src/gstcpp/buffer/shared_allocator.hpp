// A GstAllocator for memory that worker processes read without a copy.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <memory>

#include "core/isolate/shared_arena.hpp"
#include "gstcpp/element/ref.hpp"

namespace weir::gst {

// Allocates from `arena`; falls back to GStreamer's own memory when the arena is full or cannot
// meet the request.
Ref<GstAllocator> shared_allocator(std::shared_ptr<isolate::SharedArena> arena);
// True for the only allocators that our elements accept from peers: others may give device memory.
bool is_shared_allocator(GstAllocator* allocator) noexcept;

}  // namespace weir::gst
