// Deferred memory: the output of a plan, computed only when the memory is first mapped. An element
// that recognises such memory can take the plan and its input instead and fuse the plan with its
// own work; to every other element it is ordinary memory.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <atomic>
#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "core/transform/transform.hpp"
#include "gstcpp/element/ref.hpp"

namespace weir::gst {

// Counters that deferred memories update for the element that made them. Any thread; they may
// outlive the element.
struct DeferredCounts {
  std::atomic<uint64_t> computed{0};           // memories that were mapped
  std::atomic<uint64_t> divisions_by_zero{0};  // integer elements left unchanged
  std::atomic<uint64_t> bytes_gathered{0};     // copied together only to serve as input
};

struct DeferredSource {
  Ref<GstBuffer> buffer;  // must no longer be written
  guint memory = 0;       // index of the memory that is the plan's input
  std::shared_ptr<const transform::TransformPlan> plan;
  std::vector<std::byte> header = {};  // of a flexible stream; precedes the plan's output
};

// Makes a memory of the header and plan->output().bytes() bytes. It keeps its source until the
// first map, which computes the bytes once; sharing a part also maps. Mapping fails when the source
// cannot be mapped or is too small, or when memory runs out. Null when memory runs out.
GstMemory* make_deferred_memory(DeferredSource source, std::shared_ptr<DeferredCounts> counts);

// The same with `prefix` followed by the output of each source: the packed memory of a frame of
// more than 16 tensors. Precondition: there is a source.
GstMemory* make_deferred_memory(std::vector<DeferredSource> sources, std::vector<std::byte> prefix,
                                std::shared_ptr<DeferredCounts> counts);

bool is_deferred_memory(GstMemory* memory);
// The sources of a deferred memory that has not been mapped or resized yet; otherwise none.
std::vector<DeferredSource> deferred_sources(GstMemory* memory);
// The source of such a memory if it has exactly one, else nullopt.
std::optional<DeferredSource> deferred_source(GstMemory* memory);

// Releases the source; the memory can no longer be mapped. For an element that has exclusive use of
// the memory and has already taken the source.
void forget_deferred_source(GstMemory* memory);

// Adds the offer to take deferred memory to an ALLOCATION query. The offer holds only for the pad
// linked to `sink`: elements in between may forward the query.
void offer_deferral(GstQuery* query, GstPad* sink);
// Whether the peer of `source` made the offer.
bool deferral_is_offered(GstQuery* query, GstPad* source);

}  // namespace weir::gst
