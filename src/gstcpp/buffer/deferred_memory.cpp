// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/buffer/deferred_memory.hpp"

#include <algorithm>
#include <cstddef>
#include <mutex>
#include <new>

namespace weir::gst {
namespace {

constexpr char kMemoryType[] = "WeirDeferredMemory";
constexpr char kOffer[] = "weir-deferral", kSinkPad[] = "sink-pad";
constexpr size_t kAlignment = 64;

struct FreeAligned {
  void operator()(std::byte* bytes) const noexcept {
    ::operator delete (bytes, std::align_val_t{kAlignment});
  }
};

struct DeferredMemory : GstMemory {
  std::mutex mutex;  // guards the rest; held while computing, never while releasing the source
  std::vector<DeferredSource> sources;            // until `bytes` are computed
  std::vector<std::byte> prefix;                  // precedes the computed bytes
  std::unique_ptr<std::byte, FreeAligned> bytes;  // null until the first map
  std::shared_ptr<DeferredCounts> counts;
};

struct DeferredAllocator {
  GstAllocator parent;
};
struct DeferredAllocatorClass {
  GstAllocatorClass parent;
};

DeferredMemory& of(GstMemory* memory) {
  return *static_cast<DeferredMemory*>(memory);
}

// Writes the header and the plan's output to *at and advances *at past them.
bool compute(const DeferredSource& source, std::byte** at, DeferredCounts& counts) {
  const auto& plan = *source.plan;
  const size_t in_bytes = *plan.input().bytes(), out_bytes = *plan.output().bytes();
  const MappedMemory in(gst_buffer_peek_memory(source.buffer.get(), source.memory), GST_MAP_READ);
  if (!in || in.bytes().size() < in_bytes) return false;
  std::byte* const out = std::copy(source.header.begin(), source.header.end(), *at);
  const auto counters = plan.apply(in.bytes().first(in_bytes), {out, out_bytes});
  counts.divisions_by_zero += counters.divisions_by_zero;
  if (plan.is_gather()) counts.bytes_gathered += out_bytes;
  *at = out + out_bytes;
  return true;
}

// Precondition: the mutex is held.
bool compute(DeferredMemory& memory) {
  if (memory.sources.empty()) return false;
  memory.bytes.reset(static_cast<std::byte*>(
      ::operator new (memory.maxsize, std::align_val_t{kAlignment}, std::nothrow)));
  if (!memory.bytes) return false;
  std::byte* at = std::copy(memory.prefix.begin(), memory.prefix.end(), memory.bytes.get());
  for (const DeferredSource& source : memory.sources) {
    if (!compute(source, &at, *memory.counts)) {
      memory.bytes.reset();
      return false;
    }
  }
  ++memory.counts->computed;
  return true;
}

gpointer map(GstMemory* base, gsize, GstMapFlags) {
  auto& memory = of(base);
  std::vector<DeferredSource> done;
  const std::lock_guard lock(memory.mutex);
  if (!memory.bytes) {
    if (!compute(memory)) return nullptr;
    std::swap(done, memory.sources);
  }
  return memory.bytes.get();
}

void unmap(GstMemory*) {}

void end_share(gpointer of) {
  auto* memory = static_cast<GstMemory*>(of);
  gst_memory_unlock(memory, GST_LOCK_FLAG_EXCLUSIVE);
  gst_memory_unref(memory);
}

// Like system memory: the shared part is read-only, and its parent can no longer be written.
GstMemory* share(GstMemory* base, gssize offset, gssize size) {
  gpointer bytes = map(base, base->maxsize, GST_MAP_READ);
  if (!bytes || !gst_memory_lock(base, GST_LOCK_FLAG_EXCLUSIVE)) return nullptr;
  const gsize begin = base->offset + static_cast<gsize>(offset);
  const gsize length =
      size < 0 ? base->size - static_cast<gsize>(offset) : static_cast<gsize>(size);
  return gst_memory_new_wrapped(GST_MEMORY_FLAG_READONLY, bytes, base->maxsize, begin, length,
                                gst_memory_ref(base), end_share);
}

GstMemory* no_alloc(GstAllocator*, gsize, GstAllocationParams*) {
  return nullptr;  // deferred memory always needs a source
}

void free_memory(GstAllocator*, GstMemory* memory) {
  delete static_cast<DeferredMemory*>(memory);
}

void class_init(gpointer k, gpointer) {
  auto* allocator_class = static_cast<GstAllocatorClass*>(k);
  allocator_class->alloc = no_alloc;
  allocator_class->free = free_memory;
}

void init(GTypeInstance* instance, gpointer) {
  auto* allocator = GST_ALLOCATOR_CAST(instance);
  allocator->mem_type = kMemoryType;
  allocator->mem_map = map;
  allocator->mem_unmap = unmap;
  allocator->mem_share = share;
  GST_OBJECT_FLAG_SET(allocator, GST_ALLOCATOR_FLAG_CUSTOM_ALLOC);
  GST_OBJECT_FLAG_SET(allocator, GST_OBJECT_FLAG_MAY_BE_LEAKED);
}

// One allocator for the process: memories may outlive every element.
GstAllocator* allocator() {
  static GstAllocator* const only = [] {
    const GType type = g_type_register_static_simple(
        GST_TYPE_ALLOCATOR, "WeirDeferredAllocator", sizeof(DeferredAllocatorClass), class_init,
        sizeof(DeferredAllocator), init, GTypeFlags(0));
    return GST_ALLOCATOR_CAST(gst_object_ref_sink(g_object_new(type, nullptr)));
  }();
  return only;
}

// The memory tag makes base classes drop the offer instead of forwarding it.
GType offer_api() {
  static const GType api = [] {
    const gchar* tags[] = {GST_META_TAG_MEMORY_STR, nullptr};
    return gst_meta_api_type_register("WeirDeferralOfferAPI", tags);
  }();
  return api;
}

}  // namespace

GstMemory* make_deferred_memory(DeferredSource source, std::shared_ptr<DeferredCounts> counts) {
  std::vector<DeferredSource> sources;
  sources.push_back(std::move(source));
  return make_deferred_memory(std::move(sources), {}, std::move(counts));
}

GstMemory* make_deferred_memory(std::vector<DeferredSource> sources, std::vector<std::byte> prefix,
                                std::shared_ptr<DeferredCounts> counts) {
  auto* memory = new (std::nothrow) DeferredMemory();
  if (!memory) return nullptr;
  size_t bytes = prefix.size();
  for (const auto& source : sources) bytes += source.header.size() + *source.plan->output().bytes();
  memory->sources = std::move(sources);
  memory->prefix = std::move(prefix);
  memory->counts = std::move(counts);
  gst_memory_init(memory, GstMemoryFlags(0), allocator(), nullptr, bytes, kAlignment - 1, 0, bytes);
  return memory;
}

bool is_deferred_memory(GstMemory* memory) {
  return memory->allocator == allocator();
}

std::optional<DeferredSource> deferred_source(GstMemory* base) {
  auto sources = deferred_sources(base);
  if (sources.size() != 1) return std::nullopt;
  return std::move(sources[0]);
}

std::vector<DeferredSource> deferred_sources(GstMemory* base) {
  if (!is_deferred_memory(base)) return {};
  auto& memory = of(base);
  const std::lock_guard lock(memory.mutex);
  if (memory.bytes || memory.offset != 0 || memory.size != memory.maxsize) return {};
  return memory.sources;
}

void forget_deferred_source(GstMemory* base) {
  auto& memory = of(base);
  std::vector<DeferredSource> done;
  const std::lock_guard lock(memory.mutex);
  std::swap(done, memory.sources);
}

void offer_deferral(GstQuery* query, GstPad* sink) {
  const Unique<GstStructure, gst_structure_free> offer(
      gst_structure_new(kOffer, kSinkPad, GST_TYPE_PAD, sink, nullptr));
  gst_query_add_allocation_meta(query, offer_api(), offer.get());
}

bool deferral_is_offered(GstQuery* query, GstPad* source) {
  const auto peer = Ref<GstPad>::adopt(gst_pad_get_peer(source));
  if (!peer) return false;
  for (guint i = 0; i < gst_query_get_n_allocation_metas(query); ++i) {
    const GstStructure* offer = nullptr;
    if (gst_query_parse_nth_allocation_meta(query, i, &offer) != offer_api() || !offer) continue;
    GstPad* by = nullptr;
    if (!gst_structure_get(offer, kSinkPad, GST_TYPE_PAD, &by, nullptr)) continue;
    const auto offering = Ref<GstPad>::adopt(by);
    if (by == peer.get()) return true;
  }
  return false;
}

}  // namespace weir::gst
