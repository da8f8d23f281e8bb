// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/buffer/frame_builder.hpp"

#include <cstring>
#include <numeric>
#include <string>

#include "core/tensor/packed_tensors.hpp"
#include "gstcpp/buffer/allocation.hpp"
#include "gstcpp/buffer/frame_errors.hpp"
#include "gstcpp/buffer/memory_part.hpp"
#include "gstcpp/buffer/tensor_meta.hpp"

namespace weir::gst {
namespace {

Error too_many(size_t count) {
  return Error{.code = Code::LIMIT_EXCEEDED,
               .what = "a frame has too many tensors",
               .offered = std::to_string(count),
               .needed = "at most 256"};
}

size_t get_size(GstMemory* memory) {
  return gst_memory_get_sizes(memory, nullptr, nullptr);
}

size_t get_size(const BufferPart& part) {
  return part.memory ? get_size(part.memory.get()) : part.bytes.size();
}

// How many of `count` tensors or parts have a memory of their own.
size_t count_alone(size_t count) {
  return count > kMemoryLimit ? kMemoryLimit - 1 : count;
}

Status copy(GstMemory* memory, std::span<std::byte> out) {
  const MappedMemory from(memory, GST_MAP_READ);
  if (!from) return memory_not_mapped();
  if (!from.bytes().empty()) std::memcpy(out.data(), from.bytes().data(), from.bytes().size());
  return ok();
}

Status copy(const BufferPart& part, std::span<std::byte> out) {
  if (part.memory) return copy(part.memory.get(), out);
  if (!part.bytes.empty()) std::memcpy(out.data(), part.bytes.data(), part.bytes.size());
  return ok();
}

// Appends a memory, once `write` has filled it.
template <class Write>
Status append_written(Result<Ref<GstMemory>> memory, GstBuffer* buffer, const Write& write) {
  if (!memory) return memory.error();
  {
    const MappedMemory map(memory->get(), GST_MAP_WRITE);
    if (!map) return memory_not_mapped();
    if (Status status = write(map.bytes()); !status) return status;
  }
  gst_buffer_append_memory(buffer, memory->release());
  return ok();
}

// Appends the tensors from `first` on as one memory that starts with the packed header.
template <class Fill>
Status append_packed(std::span<const TensorSpec> specs, std::span<const uint64_t> sizes,
                     size_t first, GstBuffer* buffer, const Fill& fill) {
  const auto total = std::accumulate(sizes.begin(), sizes.end(), uint64_t{kPackedHeaderBytes});
  return append_written(allocate_memory(static_cast<size_t>(total)), buffer,
                        [&](std::span<std::byte> bytes) -> Status {
                          write_packed_header(specs, sizes, bytes.first<kPackedHeaderBytes>());
                          size_t at = kPackedHeaderBytes;
                          for (size_t i = 0; i < sizes.size(); ++i) {
                            const auto size = static_cast<size_t>(sizes[i]);
                            if (auto status = fill(first + i, bytes.subspan(at, size)); !status)
                              return status;
                            at += size;
                          }
                          return ok();
                        });
}

// Keeps the source maps of the chosen tensors when the buffer has one per tensor. A single map, or
// maps of regions, apply to every tensor and stay.
void keep_chosen_maps(std::span<const size_t> chosen, size_t tensors, GstBuffer* buffer) {
  const auto maps = source_maps(buffer);
  if (maps_of(buffer) != MapsOf::Tensors || tensors < 2 || maps.size() != tensors) return;
  std::vector<SourceMap> kept;
  for (const size_t index : chosen) kept.push_back(maps[index]);
  set_source_maps(buffer, std::move(kept));
}

Status extract(GstBuffer* in, const TensorPlace& place, std::span<std::byte> out) {
  if (gst_buffer_extract(in, place.offset, out.data(), place.size) == place.size) return ok();
  return memory_not_mapped();
}

}  // namespace

Status append_pieces(GstBuffer* buffer, const FrameLayout& layout, Ledger* ledger,
                     std::vector<TensorPiece>* pieces) {
  uint64_t copied = 0;
  for (const TensorPlace& place : layout.tensors()) {
    if (place.memory >= 0) {
      GstMemory* const memory = gst_buffer_peek_memory(buffer, static_cast<guint>(place.memory));
      pieces->push_back({Ref<GstMemory>::share(memory), place.spec});
      continue;
    }
    auto memory = share_bytes(buffer, place.offset, place.size, &copied);
    if (!memory) return memory.error();
    pieces->push_back({*std::move(memory), place.spec});
  }
  if (copied > 0) ledger->copied(copied);
  return ok();
}

Result<TensorPiece> make_piece(const TensorHeader& header, std::span<const std::byte> bytes) {
  auto memory = allocate_memory(kTensorHeaderBytes + bytes.size());
  if (!memory) return memory.error();
  const MappedMemory to(memory->get(), GST_MAP_WRITE);
  if (!to) return memory_not_mapped();
  write_tensor_header(header, to.bytes().first<kTensorHeaderBytes>());
  std::memcpy(to.bytes().data() + kTensorHeaderBytes, bytes.data(), bytes.size());
  return TensorPiece{*std::move(memory), header.spec};
}

Result<TensorPiece> with_header(const TensorPiece& piece, Ledger* ledger) {
  const MappedMemory from(piece.memory.get(), GST_MAP_READ);
  if (!from) return memory_not_mapped();
  TensorHeader header;
  header.spec = piece.spec;
  auto out = make_piece(header, from.bytes());
  if (out) ledger->copied(from.bytes().size());
  return out;
}

Status append_tensors(std::span<TensorPiece> pieces, GstBuffer* buffer, uint64_t* copied) {
  if (pieces.size() > kTensorLimit) return too_many(pieces.size());
  const size_t alone = count_alone(pieces.size());
  for (size_t i = 0; i < alone; ++i) gst_buffer_append_memory(buffer, pieces[i].memory.release());
  if (alone == pieces.size()) return ok();
  std::vector<TensorSpec> specs;
  std::vector<uint64_t> sizes;
  for (const TensorPiece& piece : pieces.subspan(alone)) {
    specs.push_back(piece.spec);
    sizes.push_back(get_size(piece.memory.get()));
  }
  const auto fill = [&](size_t n, std::span<std::byte> bytes) {
    return copy(pieces[n].memory.get(), bytes);
  };
  if (auto status = append_packed(specs, sizes, alone, buffer, fill); !status) return status;
  *copied += std::accumulate(sizes.begin(), sizes.end(), uint64_t{0});
  return ok();
}

Status append_tensors(std::span<TensorPiece> pieces, GstBuffer* buffer, Ledger* ledger) {
  uint64_t copied = 0;
  Status status = append_tensors(pieces, buffer, &copied);
  if (copied > 0) ledger->copied(copied);
  return status;
}

Status append_filled(std::span<const TensorSpec> specs, std::span<const uint64_t> sizes,
                     GstBuffer* buffer, const FillTensor& fill) {
  if (specs.size() > kTensorLimit) return too_many(specs.size());
  const size_t alone = count_alone(specs.size());
  for (size_t i = 0; i < alone; ++i) {
    const auto write = [&](std::span<std::byte> bytes) { return fill(i, bytes); };
    if (auto s = append_written(allocate_memory(static_cast<size_t>(sizes[i])), buffer, write); !s)
      return s;
  }
  if (alone == specs.size()) return ok();
  return append_packed(specs.subspan(alone), sizes.subspan(alone), alone, buffer, fill);
}

namespace {

// Appends one memory with the bytes of all parts; a single memory is shared.
Status append_joined(std::span<const BufferPart> parts, GstBuffer* out,
                     const AllocateBytes& allocate) {
  if (parts.size() == 1 && parts[0].memory) {
    gst_buffer_append_memory(out, gst_memory_ref(parts[0].memory.get()));
    return ok();
  }
  size_t total = 0;
  for (const auto& part : parts) total += get_size(part);
  return append_written(allocate(total), out, [&](std::span<std::byte> bytes) -> Status {
    for (const auto& part : parts) {
      if (auto status = copy(part, bytes); !status) return status;
      bytes = bytes.subspan(get_size(part));
    }
    return ok();
  });
}

}  // namespace

Status append_parts(std::span<const BufferPart> parts, GstBuffer* out,
                    const AllocateBytes& allocate) {
  const size_t alone = count_alone(parts.size());
  for (size_t i = 0; i < alone; ++i)
    if (auto status = append_joined(parts.subspan(i, 1), out, allocate); !status) return status;
  return alone < parts.size() ? append_joined(parts.subspan(alone), out, allocate) : ok();
}

namespace {

using Owners = std::vector<Ref<GstBuffer>>;

GQuark owners_quark() {
  static const GQuark quark = g_quark_from_static_string("weir-owners-of-memories");
  return quark;
}

GstFlowReturn acquire_buffer(GstBufferPool*, GstBuffer** out, GstBufferPoolAcquireParams*) {
  *out = gst_buffer_new();
  return GST_FLOW_OK;
}
void reset_buffer(GstBufferPool*, GstBuffer*) {}
void release_buffer(GstBufferPool*, GstBuffer* buffer) {
  gst_buffer_remove_all_memory(buffer);
  gst_buffer_unref(buffer);
}
gboolean start_or_stop(GstBufferPool*) {
  return TRUE;
}

void buffer_class_init(gpointer k, gpointer) {
  auto* pool_class = static_cast<GstBufferPoolClass*>(k);
  pool_class->acquire_buffer = acquire_buffer;
  pool_class->reset_buffer = reset_buffer;
  pool_class->release_buffer = release_buffer;
  pool_class->start = start_or_stop;
  pool_class->stop = start_or_stop;
}

// One for the process; it has no state and is never freed.
GstBufferPool* pool() {
  static GstBufferPool* const made = [] {
    const GType type = g_type_register_static_simple(GST_TYPE_BUFFER_POOL, "WeirSharingPool",
                                                     sizeof(GstBufferPoolClass), buffer_class_init,
                                                     sizeof(GstBufferPool), nullptr, GTypeFlags(0));
    auto* pool = static_cast<GstBufferPool*>(gst_object_ref_sink(g_object_new(type, nullptr)));
    GST_OBJECT_FLAG_SET(pool, GST_OBJECT_FLAG_MAY_BE_LEAKED);
    GstStructure* config = gst_buffer_pool_get_config(pool);
    gst_buffer_pool_config_set_params(config, nullptr, 0, 0, 0);
    gst_buffer_pool_set_config(pool, config);
    gst_buffer_pool_set_active(pool, TRUE);
    return pool;
  }();
  return made;
}

}  // namespace

Ref<GstEvent> gap_like(GstBuffer* frame) {
  if (!GST_BUFFER_PTS_IS_VALID(frame)) return {};
  return Ref<GstEvent>::adopt(gst_event_new_gap(GST_BUFFER_PTS(frame), GST_BUFFER_DURATION(frame)));
}

Ref<GstBuffer> sharing_buffer(std::span<GstBuffer* const> owners) {
  const auto pooled = [](GstBuffer* owner) { return owner->pool != nullptr; };
  GstBuffer* out = nullptr;
  if (std::none_of(owners.begin(), owners.end(), pooled) ||
      gst_buffer_pool_acquire_buffer(pool(), &out, nullptr) != GST_FLOW_OK)
    return Ref<GstBuffer>::adopt(gst_buffer_new());
  auto held = std::make_unique<Owners>();
  for (GstBuffer* owner : owners)
    if (pooled(owner)) held->push_back(Ref<GstBuffer>::share(owner));
  gst_mini_object_set_qdata(GST_MINI_OBJECT_CAST(out), owners_quark(), held.release(),
                            [](gpointer data) { delete static_cast<Owners*>(data); });
  return Ref<GstBuffer>::adopt(out);
}

Ref<GstBuffer> buffer_like(GstBuffer* in) {
  auto out = sharing_buffer({&in, 1});
  gst_buffer_copy_into(out.get(), in, GST_BUFFER_COPY_METADATA, 0, static_cast<gsize>(-1));
  return out;
}

Result<Ref<GstBuffer>> pick_tensors(GstBuffer* in, const FrameLayout& layout,
                                    std::span<const size_t> chosen, uint64_t* copied) {
  const auto& places = layout.tensors();
  auto out = buffer_like(in);
  const size_t alone = count_alone(chosen.size());
  for (const size_t index : chosen.first(alone)) {
    auto memory = share_bytes(in, places[index].offset, places[index].size, copied);
    if (!memory) return memory.error();
    gst_buffer_append_memory(out.get(), memory->release());
  }
  if (alone < chosen.size()) {
    std::vector<TensorSpec> specs;
    std::vector<uint64_t> sizes;
    for (const size_t index : chosen.subspan(alone)) {
      specs.push_back(places[index].spec);
      sizes.push_back(places[index].size);
    }
    const auto fill = [&](size_t n, std::span<std::byte> bytes) {
      return extract(in, places[chosen[n]], bytes);
    };
    if (auto status = append_packed(specs, sizes, alone, out.get(), fill); !status)
      return status.error();
    *copied += std::accumulate(sizes.begin(), sizes.end(), uint64_t{0});
  }
  keep_chosen_maps(chosen, places.size(), out.get());
  return out;
}

Result<Ref<GstBuffer>> copy_tensors(GstBuffer* in, const FrameLayout& layout,
                                    std::span<const size_t> chosen, FramePool* pool,
                                    uint64_t* copied) {
  const auto& places = layout.tensors();
  auto acquired = pool->acquire();
  if (!acquired) return acquired;
  auto out = *std::move(acquired);
  gst_buffer_copy_into(out.get(), in, GST_BUFFER_COPY_METADATA, 0, static_cast<gsize>(-1));
  FramePool::Writer writer;
  if (auto status = writer.map(*pool, out.get()); !status) return status.error();
  for (size_t i = 0; i < chosen.size(); ++i) {
    if (auto status = extract(in, places[chosen[i]], writer.payloads()[i]); !status)
      return status.error();
    *copied += places[chosen[i]].size;
  }
  writer.unmap();
  keep_chosen_maps(chosen, places.size(), out.get());
  return out;
}

}  // namespace weir::gst
