// Maps video planes that span memories: GstVideoMeta maps only the memory where a plane begins.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/buffer/mapped_video.hpp"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <utility>

#include "gstcpp/buffer/frame_errors.hpp"
#include "gstcpp/buffer/memory_part.hpp"

namespace weir::gst {
namespace {

// The byte range of the buffer that the rows of a plane occupy; the end is exclusive.
struct Extent {
  int64_t begin = 0, end = 0;
};

Extent get_extent(const GstVideoFormatInfo& format, const GstVideoMeta& meta, guint plane) {
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
    const auto [begin, end] = get_extent(*video.finfo, meta, plane);
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

namespace {

std::string size_text(uint64_t width, uint64_t height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

// The size of a frame without GStreamer's row padding.
size_t unpadded_size(const GstVideoInfo& video) {
  size_t all = 0;
  for (guint plane = 0; plane < GST_VIDEO_INFO_N_PLANES(&video); ++plane) {
    gint components[GST_VIDEO_MAX_COMPONENTS];
    gst_video_format_info_component(video.finfo, plane, components);
    const auto first = static_cast<guint>(components[0]);
    all += static_cast<size_t>(GST_VIDEO_INFO_COMP_WIDTH(&video, first)) *
           static_cast<size_t>(GST_VIDEO_INFO_COMP_PSTRIDE(&video, first)) *
           static_cast<size_t>(GST_VIDEO_INFO_COMP_HEIGHT(&video, first));
  }
  return all;
}

}  // namespace

Status check_video_meta(const GstVideoInfo& video, const GstVideoMeta& meta) {
  const bool same = meta.format == GST_VIDEO_INFO_FORMAT(&video) &&
                    meta.n_planes == GST_VIDEO_INFO_N_PLANES(&video) &&
                    meta.width >= static_cast<guint>(GST_VIDEO_INFO_WIDTH(&video)) &&
                    meta.height >= static_cast<guint>(GST_VIDEO_INFO_HEIGHT(&video));
  if (same) return ok();
  const bool planes = meta.n_planes != GST_VIDEO_INFO_N_PLANES(&video);
  const auto text = [planes](const char* format, const std::string& size, guint count) {
    return std::string(format) + " " + size +
           (planes ? " in planes: " + std::to_string(count) : "");
  };
  return Error{.code = Code::FORMAT_UNSUPPORTED,
               .what = "the video metadata of a buffer does not match its caps",
               .offered = text(gst_video_format_to_string(meta.format),
                               size_text(meta.width, meta.height), meta.n_planes),
               .needed = text(GST_VIDEO_INFO_NAME(&video),
                              size_text(static_cast<uint64_t>(GST_VIDEO_INFO_WIDTH(&video)),
                                        static_cast<uint64_t>(GST_VIDEO_INFO_HEIGHT(&video))),
                              GST_VIDEO_INFO_N_PLANES(&video)),
               .fix = "check the upstream element"};
}

Status check_video_size(const GstVideoInfo& video, size_t bytes) {
  const size_t needed = GST_VIDEO_INFO_SIZE(&video);
  if (bytes >= needed && bytes / needed == 1) return ok();
  const std::string offered = std::to_string(bytes) + " bytes";
  if (bytes >= needed)
    return Error{
        .code = Code::FRAME_SIZE,
        .what = "a video buffer holds more than one frame",
        .offered = offered,
        .needed = std::to_string(needed) + " bytes",
        .fix = "put rawvideoparse downstream of the source: it splits the data into frames"};
  Error error = video_too_small(offered, std::to_string(needed) + " bytes");
  if (bytes == unpadded_size(video)) {
    error.difference = "the rows have no padding; in GStreamer, rows of this width are " +
                       std::to_string(GST_VIDEO_INFO_PLANE_STRIDE(&video, 0)) + " bytes apart";
    error.fix = "gst_buffer_add_video_meta_full() with the actual strides";
  }
  return error;
}

Error video_too_small(std::string offered, std::string needed) {
  return Error{.code = Code::FRAME_SIZE,
               .what = "a video buffer is smaller than its caps require",
               .offered = std::move(offered),
               .needed = std::move(needed),
               .difference = {},
               .fix = "check the upstream element"};
}

}  // namespace weir::gst
