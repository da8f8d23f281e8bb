// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_preprocess/batch_pool.hpp"

#include <algorithm>
#include <bit>

#include "core/tensor/tensor_header.hpp"
#include "gstcpp/buffer/frame_errors.hpp"

namespace weir {
namespace {

constexpr uint32_t kSmallFrames = 64;  // frames until large buffers are replaced
// Limits for flexible streams, whose content decides the sizes.
constexpr uint64_t kRoundedBytes = uint64_t{1} << 24;   // larger sizes are not rounded up
constexpr uint64_t kRetainedBytes = uint64_t{1} << 28;  // in free buffers

}  // namespace

Result<BatchPool> BatchPool::make(const TensorSpec& part, uint32_t max) {
  BatchPool out;
  out.part_ = part;
  out.max_ = max;
  if (auto status = out.renew(max > 0 ? max : 1); !status) return status.error();
  return out;
}

TensorSpec BatchPool::make_batch(size_t parts) const {
  TensorSpec out = part_;
  out.shape[3] = static_cast<uint32_t>(parts);
  return out;
}

size_t BatchPool::retained(size_t room) const {
  constexpr uint64_t kMax = 8;
  if (max_ > 0) return kMax;
  return std::clamp<uint64_t>(kRetainedBytes / (room * *part_.bytes()), 1, kMax);
}

Status BatchPool::renew(size_t room) {
  auto pool = gst::FramePool::make({make_batch(room)}, max_ > 0 ? Format::Static : Format::Flexible,
                                   MediaType::Tensor, allocation_, retained(room));
  if (!pool) return pool.error();
  allocated_before_ += pool_.stats().allocated;
  pool_ = *std::move(pool);
  room_ = room;
  small_frames_ = 0;
  return ok();
}

Status BatchPool::allocate_as(const gst::Allocation& allocation) {
  if (allocation == allocation_) return ok();
  allocation_ = allocation;
  return renew(room_);
}

Result<gst::Ref<GstBuffer>> BatchPool::acquire(size_t parts, const BufferLimit& limit) {
  if (max_ == 0) {
    const bool huge = parts * *part_.bytes() > kRoundedBytes;
    const size_t needed = huge ? parts : std::bit_ceil(parts);
    small_frames_ = needed < room_ / 4 ? small_frames_ + 1 : 0;
    if (needed > room_ || small_frames_ == kSmallFrames)
      if (auto status = renew(needed); !status) return status.error();
  }
  auto buffer = pool_.acquire(limit);
  if (!buffer || max_ > 0) return buffer;
  TensorHeader header;
  header.spec = make_batch(parts);
  GstMemory* memory = gst_buffer_peek_memory(buffer->get(), 0);
  gst_memory_resize(memory, 0, kTensorHeaderBytes + parts * *part_.bytes());
  const gst::MappedMemory map(memory, GST_MAP_WRITE);
  if (!map) return gst::output_not_writable();
  write_tensor_header(header, map.bytes().first<kTensorHeaderBytes>());
  return buffer;
}

}  // namespace weir
