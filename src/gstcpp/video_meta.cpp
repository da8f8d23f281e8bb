// Metadata against caps.
#include "gstcpp/video_meta.hpp"

#include <string>

namespace weir::gst {
namespace {

std::string size_text(uint64_t width, uint64_t height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

}  // namespace

Status check_video_meta(const GstVideoInfo& video, const GstVideoMeta& meta) {
  const bool same = meta.format == GST_VIDEO_INFO_FORMAT(&video) &&
                    meta.n_planes == GST_VIDEO_INFO_N_PLANES(&video) &&
                    meta.width >= static_cast<guint>(GST_VIDEO_INFO_WIDTH(&video)) &&
                    meta.height >= static_cast<guint>(GST_VIDEO_INFO_HEIGHT(&video));
  if (!same)
    return Error{Code::FORMAT_UNSUPPORTED,
                 "the metadata of a video buffer are of another picture than its caps",
                 std::string(gst_video_format_to_string(meta.format)) + " " +
                     size_text(meta.width, meta.height),
                 std::string(GST_VIDEO_INFO_NAME(&video)) + " " +
                     size_text(static_cast<uint64_t>(GST_VIDEO_INFO_WIDTH(&video)),
                               static_cast<uint64_t>(GST_VIDEO_INFO_HEIGHT(&video))),
                 "",
                 "check the element before"};
  return ok();
}

}  // namespace weir::gst
