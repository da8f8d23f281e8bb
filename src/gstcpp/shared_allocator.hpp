// An allocator whose memory worker processes read where it lies.
#pragma once
#include <gst/gst.h>

#include <memory>

#include "core/isolate/shared_arena.hpp"
#include "gstcpp/ref.hpp"

namespace weir::gst {

// Memory of `arena`; where that has none left, or not as it is asked for, GStreamer's own memory.
Ref<GstAllocator> shared_allocator(std::shared_ptr<isolate::SharedArena> arena);
// The only allocators that our elements take from others: what others say they have may be memory
// of devices.
bool is_shared_allocator(GstAllocator* allocator) noexcept;

}  // namespace weir::gst
