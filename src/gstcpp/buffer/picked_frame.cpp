// Makes a buffer of some tensors of another buffer.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <numeric>

#include "gstcpp/buffer/frame_errors.hpp"
#include "gstcpp/buffer/frame_parts.hpp"
#include "gstcpp/buffer/sharing_buffer.hpp"
#include "gstcpp/buffer/tensor_meta.hpp"

namespace weir::gst {
namespace {

// Keeps the source maps of the chosen tensors when the buffer has one per tensor. A single map, or
// maps of regions, apply to every tensor and stay.
void keep_maps_of(std::span<const size_t> chosen, size_t tensors, GstBuffer* buffer) {
  const auto maps = source_maps(buffer);
  if (maps_of(buffer) != MapsOf::Tensors || tensors < 2 || maps.size() != tensors) return;
  std::vector<SourceMap> kept;
  for (const size_t index : chosen) kept.push_back(maps[index]);
  set_source_maps(buffer, std::move(kept));
}

Result<Ref<GstMemory>> packed(GstBuffer* in, const std::vector<FramePart>& parts,
                              std::span<const size_t> chosen, uint64_t* copied) {
  std::vector<TensorSpec> specs;
  std::vector<uint64_t> sizes;
  for (const size_t index : chosen) {
    specs.push_back(parts[index].spec);
    sizes.push_back(parts[index].size);
  }
  const size_t total = std::accumulate(sizes.begin(), sizes.end(), kPackedHeaderBytes);
  auto memory = allocate_memory(total);
  if (!memory) return memory;
  const MappedMemory map(memory->get(), GST_MAP_WRITE);
  if (!map) return memory_ran_out(total);
  write_packed_header(specs, sizes, map.bytes().first<kPackedHeaderBytes>());
  size_t at = kPackedHeaderBytes;
  for (const size_t index : chosen)
    at += gst_buffer_extract(in, parts[index].offset, map.bytes().data() + at, parts[index].size);
  if (at != total) return memory_not_mapped();
  *copied += total - kPackedHeaderBytes;
  return memory;
}

}  // namespace

Ref<GstBuffer> buffer_like(GstBuffer* in) {
  auto out = sharing_buffer({&in, 1});
  gst_buffer_copy_into(out.get(), in, GST_BUFFER_COPY_METADATA, 0, static_cast<gsize>(-1));
  return out;
}

Result<Ref<GstMemory>> share_bytes(GstBuffer* buffer, size_t offset, size_t size,
                                   uint64_t* copied) {
  guint index = 0, length = 0;
  gsize skip = 0;
  if (!gst_buffer_find_memory(buffer, offset, size, &index, &length, &skip))
    return memory_not_mapped();
  GstMemory* memory = gst_buffer_peek_memory(buffer, index);
  const bool may_share = !GST_MEMORY_IS_NO_SHARE(memory);
  if (length == 1 && may_share) {
    const bool all = skip == 0 && gst_memory_get_sizes(memory, nullptr, nullptr) == size;
    GstMemory* shared =
        all ? gst_memory_ref(memory)
            : gst_memory_share(memory, static_cast<gssize>(skip), static_cast<gssize>(size));
    if (shared) return Ref<GstMemory>::adopt(shared);
  }
  auto own = allocate_memory(size);
  if (!own) return own;
  const MappedMemory map(own->get(), GST_MAP_WRITE);
  if (!map) return memory_ran_out(size);
  if (gst_buffer_extract(buffer, offset, map.bytes().data(), size) != size)
    return memory_not_mapped();
  *copied += size;
  return own;
}

Result<Ref<GstBuffer>> pick_tensors(GstBuffer* in, const FrameParts& parts,
                                    std::span<const size_t> chosen, uint64_t* copied) {
  auto out = buffer_like(in);
  const size_t alone = chosen.size() > kMemoryLimit ? kMemoryLimit - 1 : chosen.size();
  for (const size_t index : chosen.first(alone)) {
    const FramePart& part = parts.parts()[index];
    auto memory = share_bytes(in, part.offset, part.size, copied);
    if (!memory) return memory.error();
    gst_buffer_append_memory(out.get(), memory->release());
  }
  if (alone < chosen.size()) {
    auto memory = packed(in, parts.parts(), chosen.subspan(alone), copied);
    if (!memory) return memory.error();
    gst_buffer_append_memory(out.get(), memory->release());
  }
  keep_maps_of(chosen, parts.parts().size(), out.get());
  return out;
}

Result<Ref<GstBuffer>> copy_tensors(GstBuffer* in, const FrameParts& parts,
                                    std::span<const size_t> chosen, FramePool* pool,
                                    uint64_t* copied) {
  auto acquired = pool->acquire();
  if (!acquired) return acquired;
  auto out = *std::move(acquired);
  gst_buffer_copy_into(out.get(), in, GST_BUFFER_COPY_METADATA, 0, static_cast<gsize>(-1));
  FramePool::Writer writer;
  if (auto status = writer.map(*pool, out.get()); !status) return status.error();
  for (size_t i = 0; i < chosen.size(); ++i) {
    const FramePart& part = parts.parts()[chosen[i]];
    const auto& payload = writer.payloads()[i];
    if (gst_buffer_extract(in, part.offset, payload.data(), part.size) != part.size)
      return memory_not_mapped();
    *copied += part.size;
  }
  writer.unmap();
  keep_maps_of(chosen, parts.parts().size(), out.get());
  return out;
}

}  // namespace weir::gst
