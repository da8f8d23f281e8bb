// Invalid metadata for video buffers, for an RGB picture without padding.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/video/video.h>

#include <string>
#include <vector>

namespace weir::test {

struct InvalidVideoMeta {
  GstVideoFormat format;
  guint width, height;
  gsize offset;
  gint stride;
  std::string message;  // part of the error text
};

inline std::vector<InvalidVideoMeta> invalid_video_metas(guint width, guint height) {
  const auto rgb = GST_VIDEO_FORMAT_RGB;
  const gsize bytes = gsize{3} * width * height;
  const gint stride = static_cast<gint>(3 * width);
  const char* const too_short = "a picture is shorter than its size requires";
  return {
      {GST_VIDEO_FORMAT_BGR, width, height, 0, stride, "video metadata of a buffer does not match"},
      {rgb, width - 1, height, 0, stride,
       "offered: RGB " + std::to_string(width - 1) + "x" + std::to_string(height)},
      {rgb, width, height, bytes, stride, "plane 0 at byte " + std::to_string(bytes)},
      {rgb, width, height, 1, stride, too_short},
      {rgb, width, height, 0, stride + 1, too_short},
      {rgb, width, height, 0, -stride, too_short},
      {rgb, width, height, 0, G_MININT, too_short}};
}

// Adds the invalid metadata to the buffer.
inline GstBuffer* with_invalid_meta(GstBuffer* buffer, guint width, guint height,
                                    const InvalidVideoMeta& invalid) {
  gsize offsets[GST_VIDEO_MAX_PLANES] = {0};
  gint strides[GST_VIDEO_MAX_PLANES] = {static_cast<gint>(3 * width)};
  GstVideoMeta* meta = gst_buffer_add_video_meta_full(
      buffer, GST_VIDEO_FRAME_FLAG_NONE, GST_VIDEO_FORMAT_RGB, width, height, 1, offsets, strides);
  meta->format = invalid.format;
  meta->width = invalid.width;
  meta->height = invalid.height;
  meta->offset[0] = invalid.offset;
  meta->stride[0] = invalid.stride;
  return buffer;
}

}  // namespace weir::test
