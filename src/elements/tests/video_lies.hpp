// What the metadata of a video buffer may say wrongly of an RGB picture without padding.
#pragma once
#include <gst/video/video.h>

#include <string>
#include <vector>

namespace weir::test {

struct VideoLie {
  GstVideoFormat format;
  guint width, height;
  gsize offset;
  gint stride;
  std::string words;  // of the error
};

inline std::vector<VideoLie> video_lies(guint width, guint height) {
  const auto rgb = GST_VIDEO_FORMAT_RGB;
  const gsize bytes = gsize{3} * width * height;
  const gint stride = static_cast<gint>(3 * width);
  const char* const short_one = "a picture is shorter than its size says";
  return {
      {GST_VIDEO_FORMAT_BGR, width, height, 0, stride, "metadata of a video buffer are of another"},
      {rgb, width - 1, height, 0, stride,
       "offered: RGB " + std::to_string(width - 1) + "x" + std::to_string(height)},
      {rgb, width, height, bytes, stride, "plane 0 at byte " + std::to_string(bytes)},
      {rgb, width, height, 1, stride, short_one},
      {rgb, width, height, 0, stride + 1, short_one},
      {rgb, width, height, 0, -stride, short_one},
      {rgb, width, height, 0, G_MININT, short_one}};
}

// The buffer with such metadata.
inline GstBuffer* with_lie(GstBuffer* buffer, guint width, guint height, const VideoLie& lie) {
  gsize offsets[GST_VIDEO_MAX_PLANES] = {0};
  gint strides[GST_VIDEO_MAX_PLANES] = {static_cast<gint>(3 * width)};
  GstVideoMeta* meta = gst_buffer_add_video_meta_full(
      buffer, GST_VIDEO_FRAME_FLAG_NONE, GST_VIDEO_FORMAT_RGB, width, height, 1, offsets, strides);
  meta->format = lie.format;
  meta->width = lie.width;
  meta->height = lie.height;
  meta->offset[0] = lie.offset;
  meta->stride[0] = lie.stride;
  return buffer;
}

}  // namespace weir::test
