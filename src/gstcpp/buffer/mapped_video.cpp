// Maps video planes that span memories: GstVideoMeta maps only the memory where a plane begins.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/buffer/mapped_video.hpp"

#include <algorithm>
#include <cstdlib>

#include "gstcpp/buffer/frame_errors.hpp"
#include "gstcpp/buffer/memory_part.hpp"

namespace weir::gst {
namespace {

// The byte range of the buffer that the rows of a plane occupy; the end is exclusive.
struct Extent {
  int64_t begin = 0, end = 0;
};

Extent extent_of(const GstVideoFormatInfo& format, const GstVideoMeta& meta, guint plane) {
  const int64_t stride = meta.stride[plane], width = meta.width, height = meta.height;
  int64_t rows = 0, row_bytes = 0;
  for (guint c = 0; c < GST_VIDEO_FORMAT_INFO_N_COMPONENTS(&format); ++c) {
    if (GST_VIDEO_FORMAT_INFO_PLANE(&format, c) != plane) continue;
    const int64_t pixel_bytes = GST_VIDEO_FORMAT_INFO_PSTRIDE(&format, c);  // 0: bits are packed
    rows = GST_VIDEO_FORMAT_INFO_SCALE_HEIGHT(&format, c, height);
    row_bytes =
        std::max(row_bytes, pixel_bytes > 0
                                ? pixel_bytes * GST_VIDEO_FORMAT_INFO_SCALE_WIDTH(&format, c, width)
                                : std::abs(stride));
  }
  const auto first = static_cast<int64_t>(meta.offset[plane]);
  const int64_t last = first + stride * (rows - 1);
  return {std::min(first, last), std::max(first, last) + row_bytes};
}

// Whether a plane extends beyond the memory in which it begins.
bool spans_memories(const GstVideoInfo& video, GstBuffer* buffer, const GstVideoMeta& meta) {
  const auto size = static_cast<int64_t>(gst_buffer_get_size(buffer));
  for (guint plane = 0; plane < meta.n_planes; ++plane) {
    const auto [begin, end] = extent_of(*video.finfo, meta, plane);
    const int64_t from = std::clamp<int64_t>(begin, 0, size), to = std::min(end, size);
    guint index = 0, memories = 0;
    gsize skip = 0;
    if (from < to &&
        gst_buffer_find_memory(buffer, static_cast<gsize>(from), static_cast<gsize>(to - from),
                               &index, &memories, &skip) &&
        memories > 1)
      return true;
  }
  return false;
}

}  // namespace

MappedVideo::~MappedVideo() {
  if (frame_mapped_) gst_video_frame_unmap(&frame_);
}

Status MappedVideo::map(const GstVideoInfo& video, GstBuffer* buffer, GstMapFlags flags) {
  const GstVideoMeta* meta = gst_buffer_get_video_meta(buffer);
  if (gst_buffer_n_memory(buffer) > 1 && (!meta || spans_memories(video, buffer, *meta)))
    return map_merged(video, buffer, flags);
  frame_mapped_ = gst_video_frame_map(&frame_, &video, buffer, flags);
  if (!frame_mapped_) return memory_not_mapped();
  for (guint i = 0; i < GST_VIDEO_FRAME_N_PLANES(&frame_); ++i) {
    // With metadata each plane has its own mapping, otherwise all share one.
    const GstMapInfo& info = frame_.map[meta ? i : 0];
    const auto* data = static_cast<const guint8*>(GST_VIDEO_FRAME_PLANE_DATA(&frame_, i));
    planes_[i] = {{reinterpret_cast<std::byte*>(info.data), info.size},
                  static_cast<size_t>(data - info.data),
                  GST_VIDEO_FRAME_PLANE_STRIDE(&frame_, i)};
  }
  return ok();
}

Status MappedVideo::map_merged(const GstVideoInfo& video, GstBuffer* buffer, GstMapFlags flags) {
  auto merged = one_memory(buffer);
  if (!merged) return merged.error();
  merged_ = *std::move(merged);
  copied_ = gst_buffer_get_size(buffer);
  if (flags & GST_MAP_WRITE) gst_buffer_replace_all_memory(buffer, gst_memory_ref(merged_.get()));
  merged_map_ = MappedMemory(merged_.get(), flags);
  if (!merged_map_) return memory_not_mapped();
  const GstVideoMeta* meta = gst_buffer_get_video_meta(buffer);
  for (guint i = 0; i < GST_VIDEO_INFO_N_PLANES(&video); ++i)
    planes_[i] = {merged_map_.bytes(),
                  meta ? meta->offset[i] : GST_VIDEO_INFO_PLANE_OFFSET(&video, i),
                  meta ? meta->stride[i] : GST_VIDEO_INFO_PLANE_STRIDE(&video, i)};
  return ok();
}

}  // namespace weir::gst
