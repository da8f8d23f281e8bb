// Deferred memory: what a plan makes of one memory of a buffer, computed only when somebody maps
// it. An element that knows such memories can take the plan and its input instead, and fuse the
// plan with its own work; for everybody else it is memory like any other.
#pragma once
#include <gst/gst.h>

#include <atomic>
#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "core/transform/transform.hpp"
#include "gstcpp/ref.hpp"

namespace weir::gst {

// What deferred memories tell the element that made them. Any thread, and also when the element is
// gone.
struct DeferredCounts {
  std::atomic<uint64_t> computed{0};           // memories that somebody mapped
  std::atomic<uint64_t> divisions_by_zero{0};  // integer elements left unchanged in them
  std::atomic<uint64_t> bytes_gathered{0};     // moved together for them, and not changed
};

struct DeferredSource {
  Ref<GstBuffer> buffer;  // nobody may write to it any more
  guint memory = 0;       // which of its memories is the plan's input
  std::shared_ptr<const transform::Plan> plan;
  std::vector<std::byte> header = {};  // of a flexible stream, in front of what the plan makes
};

// A memory of the header and plan->output().bytes() bytes that holds on to its source until it is
// computed, which happens once, at the first map (sharing a part of it is one). Mapping fails where
// the source cannot be mapped, is too small or memory runs out. Null when memory ran out.
GstMemory* make_deferred_memory(DeferredSource source, std::shared_ptr<DeferredCounts> counts);

// The same of `prefix` and, one behind the other, what each source makes: the packed memory of a
// frame of more than 16 tensors. Precondition: there is a source.
GstMemory* make_deferred_memory(std::vector<DeferredSource> sources, std::vector<std::byte> prefix,
                                std::shared_ptr<DeferredCounts> counts);

bool is_deferred_memory(GstMemory* memory);
// The sources of a deferred memory that nobody has mapped or resized yet, else none.
std::vector<DeferredSource> deferred_sources(GstMemory* memory);
// Of one that has a single source, else nullopt.
std::optional<DeferredSource> deferred_source(GstMemory* memory);

// Lets go of the source: from then on the memory cannot be mapped. For an element that nobody
// shares the memory with, and that has taken what the source gave.
void forget_deferred_source(GstMemory* memory);

// The ALLOCATION query. `sink` of an element that takes deferred memories says so to whatever is
// linked to it, and to nobody before that: elements in between may hand the query on.
void offer_deferral(GstQuery* query, GstPad* sink);
// Whether the pad that `source` is linked to has offered it.
bool deferral_is_offered(GstQuery* query, GstPad* source);

}  // namespace weir::gst
