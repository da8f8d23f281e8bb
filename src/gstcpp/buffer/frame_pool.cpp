// A GstBufferPool of multi-memory buffers with its own free list: GStreamer's default list costs
// two system calls a buffer and does not limit what it retains.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/buffer/frame_pool.hpp"

#include <algorithm>
#include <mutex>
#include <new>
#include <string>

#include "core/tensor/packed_tensors.hpp"
#include "core/tensor/tensor_header.hpp"
#include "gstcpp/buffer/frame_errors.hpp"

namespace weir::gst {
namespace {

struct PoolState {
  std::vector<TensorSpec> tensors;
  Format format = Format::Static;
  Allocation allocation;
  size_t retain = 0;
  size_t total_bytes = 0;
  mutable std::mutex mutex;  // guards the rest
  std::vector<GstBuffer*> free_buffers;
  uint64_t allocated = 0;
};

struct Pool {
  GstBufferPool parent;
  PoolState* state;
};
struct PoolClass {
  GstBufferPoolClass parent;
};
gpointer pool_parent_class = nullptr;

PoolState& get_state(gpointer pool) {
  return *static_cast<Pool*>(pool)->state;
}

size_t count_header_bytes(Format format) {
  return format == Format::Static ? 0 : kTensorHeaderBytes;
}

std::span<const TensorSpec> packed_part(const std::vector<TensorSpec>& tensors) {
  return tensors.size() > kMemoryLimit ? std::span(tensors).subspan(kMemoryLimit - 1)
                                       : std::span<const TensorSpec>();
}

Result<Ref<GstMemory>> packed_memory(const PoolState& s) {
  size_t total = kPackedHeaderBytes;
  for (const auto& spec : packed_part(s.tensors))
    total += count_header_bytes(s.format) + *spec.bytes();
  return allocate_memory(total, s.allocation);
}

GstFlowReturn alloc_buffer(GstBufferPool* pool, GstBuffer** out, GstBufferPoolAcquireParams*) {
  PoolState& s = get_state(pool);
  auto buffer = Ref<GstBuffer>::adopt(gst_buffer_new());
  const bool packed = s.tensors.size() > kMemoryLimit;
  const size_t alone = packed ? kMemoryLimit - 1 : s.tensors.size();
  for (size_t i = 0; i < alone + (packed ? 1 : 0); ++i) {
    auto memory = i < alone ? allocate_memory(count_header_bytes(s.format) + *s.tensors[i].bytes(),
                                              s.allocation)
                            : packed_memory(s);
    if (!memory) return GST_FLOW_ERROR;
    gst_buffer_append_memory(buffer.get(), memory->release());
  }
  {
    std::lock_guard lock(s.mutex);
    ++s.allocated;
  }
  GST_BUFFER_FLAG_UNSET(buffer.get(), GST_BUFFER_FLAG_TAG_MEMORY);  // set by appending
  *out = buffer.release();
  return GST_FLOW_OK;
}

GstFlowReturn acquire_from_pool(GstBufferPool* pool, GstBuffer** out,
                                GstBufferPoolAcquireParams* p) {
  PoolState& s = get_state(pool);
  {
    std::lock_guard lock(s.mutex);
    if (!s.free_buffers.empty()) {
      *out = s.free_buffers.back();
      s.free_buffers.pop_back();
      return GST_FLOW_OK;
    }
  }
  return alloc_buffer(pool, out, p);
}

// Restores the length of a buffer's only memory if it was shortened.
bool has_all_bytes(const PoolState& s, GstBuffer* buffer) {
  if (gst_buffer_get_size(buffer) == s.total_bytes) return true;
  if (gst_buffer_n_memory(buffer) != 1) return false;
  GstMemory* memory = gst_buffer_peek_memory(buffer, 0);
  gsize offset = 0, all = 0;
  gst_memory_get_sizes(memory, &offset, &all);
  if (offset != 0 || all < s.total_bytes) return false;
  gst_memory_resize(memory, 0, s.total_bytes);
  return true;
}

// Whether an application mapped a memory and has not unmapped it: it can never be written again.
bool has_mapped_memory(GstBuffer* buffer) {
  // A kind of lock that has no other use goes with no other lock.
  constexpr auto kOwn = static_cast<GstLockFlags>(GST_LOCK_FLAG_EXCLUSIVE << 1);
  for (guint i = 0; i < gst_buffer_n_memory(buffer); ++i) {
    auto* const memory = GST_MINI_OBJECT_CAST(gst_buffer_peek_memory(buffer, i));
    if (!gst_mini_object_lock(memory, kOwn)) return true;
    gst_mini_object_unlock(memory, kOwn);
  }
  return false;
}

void release_to_pool(GstBufferPool* pool, GstBuffer* buffer) {
  PoolState& s = get_state(pool);
  const bool intact = !GST_BUFFER_FLAG_IS_SET(buffer, GST_BUFFER_FLAG_TAG_MEMORY) &&
                      gst_buffer_is_all_memory_writable(buffer) && !has_mapped_memory(buffer) &&
                      has_all_bytes(s, buffer);
  {
    std::lock_guard lock(s.mutex);
    if (intact && s.free_buffers.size() < s.retain) {
      s.free_buffers.push_back(buffer);
      return;
    }
  }
  gst_buffer_unref(buffer);
}

gboolean start(GstBufferPool*) {
  return TRUE;
}

gboolean stop(GstBufferPool* pool) {
  std::vector<GstBuffer*> buffers;
  {
    PoolState& s = get_state(pool);
    std::lock_guard lock(s.mutex);
    buffers.swap(s.free_buffers);
  }
  for (GstBuffer* buffer : buffers) gst_buffer_unref(buffer);
  return TRUE;
}

void pool_finalize(GObject* object) {
  stop(GST_BUFFER_POOL_CAST(object));
  delete reinterpret_cast<Pool*>(object)->state;
  G_OBJECT_CLASS(pool_parent_class)->finalize(object);
}

void pool_class_init(gpointer k, gpointer) {
  pool_parent_class = g_type_class_peek_parent(k);
  G_OBJECT_CLASS(k)->finalize = pool_finalize;
  auto* pool_class = static_cast<GstBufferPoolClass*>(k);
  pool_class->alloc_buffer = alloc_buffer;
  pool_class->acquire_buffer = acquire_from_pool;
  pool_class->release_buffer = release_to_pool;
  pool_class->start = start;
  pool_class->stop = stop;
}

void pool_init(GTypeInstance* instance, gpointer) {
  reinterpret_cast<Pool*>(instance)->state = new PoolState;
}

// A process may contain several copies of this code, one in each plug-in: each has its own type.
GType pool_type() {
  static const GType type = [] {
    const char* free_name =
        g_type_from_name("WeirFramePool") ? "WeirFramePoolOfWeirnet" : "WeirFramePool";
    return g_type_register_static_simple(GST_TYPE_BUFFER_POOL, free_name, sizeof(PoolClass),
                                         pool_class_init, sizeof(Pool), pool_init, GTypeFlags(0));
  }();
  return type;
}

}  // namespace

Result<FramePool> FramePool::make(std::vector<TensorSpec> tensors, Format format, MediaType media,
                                  Allocation allocation, size_t retain) {
  if (tensors.empty() || tensors.size() > kTensorLimit)
    return Error{.code = Code::LIMIT_EXCEEDED,
                 .what = "a frame has too few or too many tensors",
                 .offered = std::to_string(tensors.size()),
                 .needed = "1 to 256"};
  size_t total = tensors.size() > kMemoryLimit ? kPackedHeaderBytes : 0;
  for (const auto& spec : tensors) {
    const auto bytes = spec.bytes();
    if (!bytes || *bytes > (uint64_t{1} << 40))
      return Error{.code = Code::LIMIT_EXCEEDED,
                   .what = "a tensor is too big",
                   .offered = spec.to_string(),
                   .needed = "at most 1 TiB"};
    total += *bytes + count_header_bytes(format);
  }
  FramePool out;
  out.tensors_ = tensors;
  out.header_bytes_ = count_header_bytes(format);
  out.media_ = media;
  auto* object = static_cast<GstBufferPool*>(g_object_new(pool_type(), nullptr));
  out.pool_ = Ref<GstBufferPool>::adopt(static_cast<GstBufferPool*>(gst_object_ref_sink(object)));
  PoolState& s = get_state(object);
  s.tensors = std::move(tensors);
  s.format = format;
  s.allocation = std::move(allocation);
  s.retain = retain;
  s.total_bytes = total;
  s.free_buffers.reserve(retain);
  GstStructure* config = gst_buffer_pool_get_config(object);
  gst_buffer_pool_config_set_params(config, nullptr,
                                    static_cast<guint>(std::min<size_t>(total, G_MAXUINT)), 0, 0);
  if (!gst_buffer_pool_set_config(object, config) || !gst_buffer_pool_set_active(object, TRUE))
    return Error{.code = Code::INTERNAL, .what = "a buffer pool cannot be started"};
  return out;
}

Result<Ref<GstBuffer>> FramePool::acquire() {
  GstBuffer* buffer = nullptr;
  if (gst_buffer_pool_acquire_buffer(pool_.get(), &buffer, nullptr) != GST_FLOW_OK)
    return memory_ran_out(get_state(pool_.get()).total_bytes);
  return Ref<GstBuffer>::adopt(buffer);
}

Result<Ref<GstBuffer>> FramePool::acquire(const BufferLimit& limit) {
  if (auto status = limit.check(get_state(pool_.get()).total_bytes); !status) return status.error();
  return acquire();
}

Status FramePool::Writer::map(const FramePool& pool, GstBuffer* buffer, Format format) {
  unmap();
  const auto failed = [] { return output_not_writable(); };
  const guint memories = gst_buffer_n_memory(buffer);
  for (guint i = 0; i < memories; ++i) {
    maps_.emplace_back(gst_buffer_peek_memory(buffer, i), GST_MAP_WRITE);
    if (!maps_.back()) return failed();
  }
  const auto& tensors = pool.tensors_;
  const size_t head = pool.header_bytes_;
  if (memories < std::min(tensors.size(), kMemoryLimit)) return failed();
  const auto append = [&](const TensorSpec& spec, std::span<std::byte> at) {
    if (head > 0) {
      TensorHeader header;
      header.spec = spec;
      header.format = format;
      header.media = pool.media_;
      write_tensor_header(header, at.first<kTensorHeaderBytes>());
    }
    payloads_.push_back(at.subspan(head));
  };
  const auto packed = packed_part(tensors);
  for (size_t i = 0; i < tensors.size() - packed.size(); ++i) append(tensors[i], maps_[i].bytes());
  if (packed.empty()) return ok();
  std::vector<uint64_t> sizes;
  for (const auto& spec : packed) sizes.push_back(head + *spec.bytes());
  const auto block = maps_.back().bytes();
  write_packed_header(packed, sizes, block.first<kPackedHeaderBytes>());
  size_t offset = kPackedHeaderBytes;
  for (size_t i = 0; i < packed.size(); ++i) {
    append(packed[i], block.subspan(offset, sizes[i]));
    offset += sizes[i];
  }
  return ok();
}

FramePoolStats FramePool::stats() const {
  if (!pool_) return {};
  const PoolState& s = get_state(pool_.get());
  std::lock_guard lock(s.mutex);
  return {s.allocated, s.free_buffers.size()};
}

}  // namespace weir::gst
