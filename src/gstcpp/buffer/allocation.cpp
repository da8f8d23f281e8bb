// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/buffer/allocation.hpp"

#include <algorithm>
#include <bit>
#include <cstdlib>

#include "gstcpp/buffer/frame_errors.hpp"
#include "gstcpp/element/own_thread_query.hpp"

namespace weir::gst {
namespace {

constexpr size_t kMaxAlignment = 4096, kMaxPadding = 65536;  // the limits that abi.h sets
// Smaller blocks come from GStreamer's allocator, which is faster but aborts when memory runs out.
// A process that cannot get a page cannot get a GstBuffer either.
constexpr size_t kAlwaysThere = 4096;

// Returns null when memory runs out.
GstMemory* allocate_aligned(size_t bytes, size_t alignment, size_t padding) {
  size_t capacity = 0, rounded = 0;
  if (__builtin_add_overflow(bytes, padding, &capacity) ||
      __builtin_add_overflow(capacity, alignment - 1, &rounded))
    return nullptr;
  void* data = std::aligned_alloc(alignment, rounded / alignment * alignment);
  if (!data) return nullptr;
  return gst_memory_new_wrapped(GstMemoryFlags(0), data, capacity, 0, bytes, data, std::free);
}

}  // namespace

GstAllocationParams Allocation::params() const noexcept {
  GstAllocationParams out;
  gst_allocation_params_init(&out);
  out.align = alignment - 1;  // a mask
  out.padding = padding;
  return out;
}

Result<Ref<GstMemory>> allocate_memory(size_t bytes, const Allocation& allocation) {
  GstMemory* memory = nullptr;
  if (allocation.allocator || bytes < kAlwaysThere) {
    auto params = allocation.params();
    memory = gst_allocator_alloc(allocation.allocator.get(), bytes, &params);
  } else {
    // gst_memory_alignment is a mask; a program may raise it for all memory.
    const size_t alignment =
        std::max(allocation.alignment, std::bit_ceil(gst_memory_alignment + 1));
    memory = allocate_aligned(bytes, alignment, allocation.padding);
  }
  if (!memory) return memory_ran_out(bytes);
  return Ref<GstMemory>::adopt(memory);
}

Result<Ref<GstBuffer>> allocate_buffer(size_t bytes, const Allocation& allocation) {
  auto memory = allocate_memory(bytes, allocation);
  if (!memory) return memory.error();
  auto buffer = Ref<GstBuffer>::adopt(gst_buffer_new());
  gst_buffer_append_memory(buffer.get(), memory->release());
  return buffer;
}

Allocation parse_allocation(GstQuery* query, const Allocation& unasked) {
  const guint preferences = gst_query_get_n_allocation_params(query);
  if (preferences == 0) return unasked;
  Allocation out;
  for (guint i = 0; i < preferences; ++i) {
    GstAllocationParams params;
    GstAllocator* allocator = nullptr;
    gst_query_parse_nth_allocation_param(query, i, &allocator, &params);
    auto owned = Ref<GstAllocator>::adopt(allocator);
    if (owned && !out.allocator && is_shared_allocator(owned.get())) out.allocator = owned;
    if (params.align < kMaxAlignment)
      out.alignment = std::max(out.alignment, std::bit_ceil(params.align + 1));
    if (params.padding <= kMaxPadding) out.padding = std::max(out.padding, params.padding);
  }
  return out;
}

Ref<GstQuery> ask_peer(GstPad* source, GstCaps* caps, const Ledger& ledger) {
  auto query = Ref<GstQuery>::adopt(gst_query_new_allocation(caps, FALSE));
  const bool answered = frames_flow(ledger) ? query_on_own_thread(source, query.get())
                                            : gst_pad_peer_query(source, query.get());
  return answered ? query : Ref<GstQuery>();
}

Allocation wanted_by_peer(GstPad* source, GstCaps* caps, const Ledger& ledger,
                          const Allocation& unasked) {
  const auto query = ask_peer(source, caps, ledger);
  return query ? parse_allocation(query.get(), unasked) : unasked;
}

void offer(GstQuery* query, const Allocation& allocation) {
  const auto params = allocation.params();
  gst_query_add_allocation_param(query, allocation.allocator.get(), &params);
}

namespace {

using Arena = std::shared_ptr<isolate::SharedArena>;
using Block = std::shared_ptr<isolate::SharedBlock>;

struct Allocator {
  GstAllocator parent;
  Arena* arena;
};
gpointer allocator_parent_class = nullptr;

void give_back(gpointer block) {
  const std::unique_ptr<Block> owned(static_cast<Block*>(block));
}

GstMemory* alloc(GstAllocator* allocator, gsize size, GstAllocationParams* params) {
  GstAllocationParams plain;
  gst_allocation_params_init(&plain);
  if (!params) params = &plain;
  gsize total = 0;
  const bool fits = !__builtin_add_overflow(params->prefix, size, &total) &&
                    !__builtin_add_overflow(total, params->padding, &total) &&
                    params->align < isolate::SharedBlock::kPage;
  const Arena& arena = *reinterpret_cast<Allocator*>(allocator)->arena;
  Block block = fits ? arena->allocate(total) : nullptr;
  if (!block && params->prefix > 0) return gst_allocator_alloc(nullptr, size, params);
  if (!block) {
    auto memory = allocate_memory(size, {params->align + 1, params->padding, {}});
    return memory ? memory->release() : nullptr;
  }
  std::byte* const data = block->data();
  const gsize whole = block->bytes();
  return gst_memory_new_wrapped(params->flags, data, whole, params->prefix, size,
                                new Block(std::move(block)), give_back);
}

// The memories are GStreamer's wrapped ones, which free themselves.
void no_free(GstAllocator*, GstMemory*) {}

void allocator_finalize(GObject* object) {
  delete reinterpret_cast<Allocator*>(object)->arena;
  G_OBJECT_CLASS(allocator_parent_class)->finalize(object);
}

void allocator_class_init(gpointer k, gpointer) {
  allocator_parent_class = g_type_class_peek_parent(k);
  G_OBJECT_CLASS(k)->finalize = allocator_finalize;
  auto* allocator_class = static_cast<GstAllocatorClass*>(k);
  allocator_class->alloc = alloc;
  allocator_class->free = no_free;
}

void allocator_init(GTypeInstance* instance, gpointer) {
  GST_ALLOCATOR_CAST(instance)->mem_type = "WeirShared";
  reinterpret_cast<Allocator*>(instance)->arena = new Arena;
}

// A process may contain several copies of this code, one in each plug-in: they share a type, so
// that elements of one accept the allocators of another.
GType type() {
  static const GType t = [] {
    const GType known = g_type_from_name("WeirSharedAllocator");
    return known != 0 ? known
                      : g_type_register_static_simple(
                            GST_TYPE_ALLOCATOR, "WeirSharedAllocator", sizeof(GstAllocatorClass),
                            allocator_class_init, sizeof(Allocator), allocator_init, GTypeFlags(0));
  }();
  return t;
}

}  // namespace

Ref<GstAllocator> shared_allocator(std::shared_ptr<isolate::SharedArena> arena) {
  auto* made = static_cast<GstAllocator*>(g_object_new(type(), nullptr));
  gst_object_ref_sink(made);
  *reinterpret_cast<Allocator*>(made)->arena = std::move(arena);
  return Ref<GstAllocator>::adopt(made);
}

bool is_shared_allocator(GstAllocator* allocator) noexcept {
  return G_TYPE_CHECK_INSTANCE_TYPE(allocator, type());
}

}  // namespace weir::gst
