// What the metadata of a video buffer must not lie about.
#pragma once
#include <gst/video/video.h>

#include "weir/result.hpp"

namespace weir::gst {

// FORMAT_UNSUPPORTED unless the metadata describe a picture of the caps' format and at least its
// size: GStreamer's own mapping answers others with a critical warning. Offsets and strides are
// the reader's to check.
Status check_video_meta(const GstVideoInfo& video, const GstVideoMeta& meta);

}  // namespace weir::gst
