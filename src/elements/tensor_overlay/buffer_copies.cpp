// Copies buffers into a pool that is kept while their size stays the same.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_overlay/buffer_copies.hpp"

#include <gst/video/video.h>

#include "gstcpp/buffer/frame_errors.hpp"

namespace weir {
namespace {

// gst_buffer_copy_into() leaves out metas that describe the memory when it does not copy the
// memory, such as where the planes of a padded picture lie.
void copy_layout(GstBuffer* from, GstBuffer* to) {
  GstVideoMeta* layout = gst_buffer_get_video_meta(from);
  if (!layout || gst_buffer_get_video_meta(to)) return;
  GstVideoMeta* copy = gst_buffer_add_video_meta_full(
      to, layout->flags, layout->format, layout->width, layout->height, layout->n_planes,
      layout->offset, layout->stride);
  copy->id = layout->id;
}

}  // namespace

Status BufferCopies::set_size(size_t bytes) {
  if (pool_ && bytes_ == bytes) return ok();
  pool_ = {};
  if (bytes > UINT32_MAX) return gst::memory_ran_out(bytes);
  const TensorSpec all{ElementType::UInt8, Shape{static_cast<uint32_t>(bytes)}, ""};
  auto pool = gst::FramePool::make({all}, Format::Static);
  if (!pool) return pool.error();
  pool_ = *std::move(pool);
  bytes_ = bytes;
  return ok();
}

Result<gst::Ref<GstBuffer>> BufferCopies::copy_of(GstBuffer* buffer) {
  const size_t bytes = gst_buffer_get_size(buffer);
  if (auto status = set_size(bytes); !status) return status.error();
  auto out = pool_.acquire();
  if (!out) return out;
  const gst::Mapped map(out->get(), GST_MAP_WRITE);
  if (!map) return gst::memory_ran_out(bytes);
  if (gst_buffer_extract(buffer, 0, map.bytes().data(), bytes) != bytes)
    return gst::memory_not_mapped();
  constexpr int kAllButMemory =
      GST_BUFFER_COPY_FLAGS | GST_BUFFER_COPY_TIMESTAMPS | GST_BUFFER_COPY_META;
  gst_buffer_copy_into(out->get(), buffer, static_cast<GstBufferCopyFlags>(kAllButMemory), 0,
                       static_cast<gsize>(-1));
  copy_layout(buffer, out->get());
  return out;
}

}  // namespace weir
