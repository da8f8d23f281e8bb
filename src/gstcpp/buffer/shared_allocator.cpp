// Wraps blocks of a shared-memory arena as GstMemory.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/buffer/shared_allocator.hpp"

#include <memory>

#include "gstcpp/buffer/allocation.hpp"

namespace weir::gst {
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
