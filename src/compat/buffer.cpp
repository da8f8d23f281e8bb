// Reads and appends tensors of buffers, including those packed into the 16th memory.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <bit>
#include <cstring>
#include <span>
#include <string>

#include "compat/guard.hpp"
#include "compat/spec.hpp"
#include "core/tensor/packed_tensors.hpp"
#include "gstcpp/buffer/allocation.hpp"
#include "gstcpp/element/ref.hpp"
#include "nnstreamer_plugin_api.h"

using namespace weir::compat;

namespace {

constexpr guint kLast = NNS_TENSOR_MEMORY_MAX - 1;
constexpr gsize kMallocAlignment = 8;  // the minimum of GStreamer's allocator

// Precedes a 16th memory that packs several tensors; entries are those of the 17th tensor on.
struct PackedHeader {
  uint32_t magic, version, extra_count, padding;
  uint64_t first_bytes;  // size of the 16th tensor
  GstTensorInfo extra[NNS_TENSOR_SIZE_EXTRA_LIMIT];
};
static_assert(sizeof(PackedHeader) == weir::kPackedHeaderBytes);

PackedHeader read_header(std::span<const std::byte> bytes) {
  PackedHeader header;
  std::memcpy(&header, bytes.data(), sizeof header);
  return header;
}

// Returns the ranges of the packed tensors: from their own headers if the first one has one.
weir::Result<std::vector<weir::ByteRange>> ranges_in(std::span<const std::byte> bytes) {
  auto flexible = weir::read_packed_tensors(bytes, weir::Format::Flexible);
  return flexible ? flexible : weir::read_packed_tensors(bytes, weir::Format::Static);
}

// Makes the 16th memory with one more tensor appended; null when it cannot be mapped.
GstMemory* packed_with(GstMemory* last, GstMemory* added, const GstTensorInfo& info) {
  const weir::gst::MappedMemory old(last, GST_MAP_READ), more(added, GST_MAP_READ);
  if (!old || !more) return nullptr;
  const bool packed = weir::is_packed(old.bytes());
  PackedHeader header{};
  if (packed) {
    header = read_header(old.bytes());
  } else {
    header.magic = 0xf00dc0de;
    header.first_bytes = old.bytes().size();
  }
  if (header.extra_count >= NNS_TENSOR_SIZE_EXTRA_LIMIT) return nullptr;
  header.extra[header.extra_count] = info;
  header.extra[header.extra_count++].name = nullptr;
  const auto data = packed ? old.bytes().subspan(sizeof header) : old.bytes();
  auto made = weir::gst::allocate_memory(sizeof header + data.size() + more.bytes().size());
  if (!made) return nullptr;
  const weir::gst::MappedMemory to(made->get(), GST_MAP_WRITE);
  std::memcpy(to.bytes().data(), &header, sizeof header);
  std::copy(data.begin(), data.end(), to.bytes().begin() + sizeof header);
  std::copy(more.bytes().begin(), more.bytes().end(),
            to.bytes().begin() + static_cast<ptrdiff_t>(sizeof header + data.size()));
  return made->release();
}

// Takes no ownership.
bool append(GstBuffer* buffer, GstMemory* memory, const GstTensorInfo& info) {
  const guint count = gst_buffer_n_memory(buffer);
  if (count < NNS_TENSOR_MEMORY_MAX) {
    gst_buffer_append_memory(buffer, gst_memory_ref(memory));
    return true;
  }
  if (count > NNS_TENSOR_MEMORY_MAX) return false;
  GstMemory* packed = packed_with(gst_buffer_peek_memory(buffer, kLast), memory, info);
  if (packed) gst_buffer_replace_memory(buffer, kLast, packed);
  return packed;
}

}  // namespace

guint gst_tensor_buffer_get_count(GstBuffer* buffer) {
  if (!given(__func__, {buffer})) return 0;
  const guint count = gst_buffer_n_memory(buffer);
  if (count < NNS_TENSOR_MEMORY_MAX) return count;
  const weir::gst::MappedMemory last(gst_buffer_peek_memory(buffer, kLast), GST_MAP_READ);
  if (!last || !weir::is_packed(last.bytes())) return NNS_TENSOR_MEMORY_MAX;
  return or_else<guint>(__func__, 0, [&]() -> guint {
    const auto ranges = ranges_in(last.bytes());
    return ranges ? kLast + static_cast<guint>(ranges->size()) : NNS_TENSOR_MEMORY_MAX;
  });
}

GstMemory* gst_tensor_buffer_get_nth_memory(GstBuffer* buffer, guint index) {
  if (!given(__func__, {buffer})) return nullptr;
  const guint count = gst_buffer_n_memory(buffer);
  if (index < kLast || count <= kLast)
    return index < count ? gst_buffer_get_memory(buffer, index) : nullptr;
  return or_else<GstMemory*>(__func__, nullptr, [&]() -> GstMemory* {
    GstMemory* last = gst_buffer_peek_memory(buffer, kLast);
    weir::ByteRange range;
    {
      const weir::gst::MappedMemory mapped(last, GST_MAP_READ);
      if (!mapped || !weir::is_packed(mapped.bytes()))
        return index == kLast ? gst_memory_ref(last) : nullptr;
      const auto ranges = ranges_in(mapped.bytes());
      if (!ranges || index - kLast >= ranges->size()) return nullptr;
      range = (*ranges)[index - kLast];
    }
    return gst_memory_share(last, static_cast<gssize>(range.offset),
                            static_cast<gssize>(range.size));
  });
}

gboolean gst_tensor_buffer_append_memory(GstBuffer* buffer, GstMemory* memory,
                                         const GstTensorInfo* info) {
  if (!memory) return given(__func__, {memory});
  const bool done = given(__func__, {buffer, info}) && gst_buffer_is_writable(buffer) &&
                    append(buffer, memory, *info);
  gst_memory_unref(memory);
  return done;
}

void gst_tensor_alloc_init(gsize alignment) {
  if (alignment == 0) return;
  // A mask is a power of two minus one; GStreamer takes masks too.
  const gsize wanted = std::has_single_bit(alignment) ? alignment : alignment + 1;
  if (!std::has_single_bit(wanted))
    return warn(__func__, "the alignment " + std::to_string(alignment) +
                              " is neither a power of two nor a power of two minus one");
  gst_memory_alignment = std::max(wanted, kMallocAlignment) - 1;
}
