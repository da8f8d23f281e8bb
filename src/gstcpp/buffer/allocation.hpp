// Allocation: the alignment, padding and allocator that a peer requests by the ALLOCATION query.
// shared_allocator: gives memory that worker processes see.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <memory>

#include "core/isolate/shared_arena.hpp"
#include "core/ledger/ledger.hpp"
#include "gstcpp/element/ref.hpp"
#include "weir/result.hpp"

namespace weir::gst {

// Sizes in bytes. Memory starts at a multiple of `alignment`, a power of two, and is followed by
// `padding` readable bytes.
struct Allocation {
  size_t alignment = 64, padding = 0;  // a cache line
  Ref<GstAllocator> allocator;         // null = GStreamer's own

  bool operator==(const Allocation&) const = default;
  GstAllocationParams params() const noexcept;
};

// Allocates memory as `allocation` specifies. Use it for every size that comes from data, caps or
// properties: GStreamer's own allocator aborts the process when memory runs out.
// Errors: OUT_OF_MEMORY.
Result<Ref<GstMemory>> allocate_memory(size_t bytes, const Allocation& allocation = {});
// The same, as a buffer with one memory.
Result<Ref<GstBuffer>> allocate_buffer(size_t bytes, const Allocation& allocation = {});

// Returns the largest values that an answered query requests, at least the defaults; `unasked` when
// it requests none.
Allocation parse_allocation(GstQuery* query, const Allocation& unasked = {});
// Sends an ALLOCATION query with `caps` to the peer of `source`; null when it is not answered.
// Streaming thread. Once frames flow (see `ledger`) the query enters no other thread.
Ref<GstQuery> ask_peer(GstPad* source, GstCaps* caps, const Ledger& ledger);
// parse_allocation() of the query that the peer handled; `unasked` if it handled none.
Allocation wanted_by_peer(GstPad* source, GstCaps* caps, const Ledger& ledger,
                          const Allocation& unasked = {});
// Adds `allocation` to a query.
void offer(GstQuery* query, const Allocation& allocation);

// Allocates from `arena`; falls back to GStreamer's own memory when the arena is full or cannot
// meet the request.
Ref<GstAllocator> shared_allocator(std::shared_ptr<isolate::SharedArena> arena);
// True for the only allocators that our elements accept from peers: others may give device memory.
bool is_shared_allocator(GstAllocator* allocator) noexcept;

}  // namespace weir::gst
