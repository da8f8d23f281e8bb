// Checks a buffer's GstVideoMeta and size against its caps.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/buffer/video_meta.hpp"

#include <cstdint>
#include <string>
#include <utility>

namespace weir::gst {
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
