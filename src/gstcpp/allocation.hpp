// Allocation: how the next element wants memory, by the ALLOCATION query.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include "core/ledger/ledger.hpp"
#include "gstcpp/ref.hpp"
#include "weir/result.hpp"

namespace weir::gst {

// Bytes. Memory starts at a multiple of alignment, a power of two, and has padding readable bytes
// behind it.
struct Allocation {
  size_t alignment = 64, padding = 0;  // a cache line
  Ref<GstAllocator> allocator;         // null = GStreamer's own

  bool operator==(const Allocation&) const = default;
  GstAllocationParams params() const noexcept;
};

// Memory as `allocation` says. Everything whose size comes from data, caps or properties is
// allocated here: GStreamer's own allocator ends the process when memory runs out.
// Errors: OUT_OF_MEMORY.
Result<Ref<GstMemory>> allocate_memory(size_t bytes, const Allocation& allocation = {});
// The same as a buffer with one memory.
Result<Ref<GstBuffer>> allocate_buffer(size_t bytes, const Allocation& allocation = {});

// What an answered query asks for at most, no less than the default; `unasked` when it asks
// nothing.
Allocation allocation_of(GstQuery* answered, const Allocation& unasked = {});
// What the element behind `source` answers to an ALLOCATION query with `caps`; null when it has no
// answer. Streaming thread. While frames flow, by `ledger`, no other thread is asked.
Ref<GstQuery> ask_peer(GstPad* source, GstCaps* caps, const Ledger& ledger);
// How it wants memory: allocation_of() of its answer, `unasked` without one.
Allocation wanted_by_peer(GstPad* source, GstCaps* caps, const Ledger& ledger,
                          const Allocation& unasked = {});
// Adds it to the answer of a query.
void offer(GstQuery* query, const Allocation& allocation);

}  // namespace weir::gst
