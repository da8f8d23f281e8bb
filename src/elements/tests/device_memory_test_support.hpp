// DeviceAllocator: test memory that, like a device's, can be read only through its map function.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <atomic>
#include <cstdlib>
#include <vector>

#include "gstcpp/element/ref.hpp"

namespace weir::testing_memory {

enum class Refuses { Nothing, Writing, Everything };

// The "device" stores the complement of what a mapping shows, so reading without mapping gives
// wrong data. Counts its mappings.
class DeviceAllocator {
 public:
  explicit DeviceAllocator(Refuses refuses, guint flags = 0)
      : refuses_(refuses),
        flags_(flags),
        allocator_(gst::Ref<GstAllocator>::adopt(
            static_cast<GstAllocator*>(gst_object_ref_sink(g_object_new(type(), nullptr))))) {
    allocator_.get()->mem_type = "WeirTestDevice";
    allocator_.get()->mem_map = map;
    allocator_.get()->mem_unmap = unmap;
    allocator_.get()->mem_share = share;
    GST_OBJECT_FLAG_SET(allocator_.get(), GST_ALLOCATOR_FLAG_CUSTOM_ALLOC);
  }

  // A memory whose mapping shows these bytes.
  GstMemory* holding(const std::vector<uint8_t>& shown) {
    const size_t bytes = shown.size();
    auto* memory = new Memory{{}, this, static_cast<unsigned char*>(std::malloc(bytes)), nullptr};
    for (size_t i = 0; i < bytes; ++i) memory->device[i] = static_cast<unsigned char>(~shown[i]);
    gst_memory_init(GST_MEMORY_CAST(memory), GstMemoryFlags(flags_ | GST_MEMORY_FLAG_NO_SHARE),
                    allocator_.get(), nullptr, bytes, 63, 0, bytes);
    return GST_MEMORY_CAST(memory);
  }
  int mapped() const { return mapped_; }      // current
  int mappings() const { return mappings_; }  // total

 private:
  struct Memory {
    GstMemory memory;
    DeviceAllocator* owner;
    unsigned char* device;
    unsigned char* shown;  // while mapped
  };
  struct Instance {
    GstAllocator parent;
  };
  struct Class {
    GstAllocatorClass parent;
  };

  static GType type() {
    static const GType registered = g_type_register_static_simple(
        GST_TYPE_ALLOCATOR, "WeirTestDeviceAllocator", sizeof(Class),
        [](gpointer k, gpointer) {
          static_cast<GstAllocatorClass*>(k)->alloc =
              [](GstAllocator*, gsize, GstAllocationParams*) -> GstMemory* { return nullptr; };
          static_cast<GstAllocatorClass*>(k)->free = free;
        },
        sizeof(Instance), nullptr, GTypeFlags(0));
    return registered;
  }
  static void free(GstAllocator*, GstMemory* base) {
    auto* memory = reinterpret_cast<Memory*>(base);
    std::free(memory->device);
    delete memory;
  }
  static gpointer map(GstMemory* base, gsize size, GstMapFlags flags) {
    auto* memory = reinterpret_cast<Memory*>(base);
    DeviceAllocator& owner = *memory->owner;
    if (owner.refuses_ == Refuses::Everything) return nullptr;
    if (owner.refuses_ == Refuses::Writing && (flags & GST_MAP_WRITE)) return nullptr;
    if (memory->shown) return nullptr;  // one mapping at a time, as on some devices
    memory->shown = static_cast<unsigned char*>(std::malloc(size));
    for (gsize i = 0; i < size; ++i)
      memory->shown[i] = static_cast<unsigned char>(~memory->device[i]);
    ++owner.mapped_;
    ++owner.mappings_;
    return memory->shown;
  }
  static void unmap(GstMemory* base) {
    auto* memory = reinterpret_cast<Memory*>(base);
    for (gsize i = 0; i < base->maxsize; ++i)
      memory->device[i] = static_cast<unsigned char>(~memory->shown[i]);
    std::free(memory->shown);
    memory->shown = nullptr;
    --memory->owner->mapped_;
  }
  static GstMemory* share(GstMemory*, gssize, gssize) { return nullptr; }

  Refuses refuses_;
  guint flags_;
  std::atomic<int> mapped_{0}, mappings_{0};
  gst::Ref<GstAllocator> allocator_;
};

}  // namespace weir::testing_memory
