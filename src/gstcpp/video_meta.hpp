// What the metadata and the size of a video buffer must not lie about.
#pragma once
#include <gst/video/video.h>

#include "weir/result.hpp"

namespace weir::gst {

// FORMAT_UNSUPPORTED unless the metadata describe a picture of the caps' format and at least its
// size: GStreamer's own mapping answers others with a critical warning. Offsets and strides are
// the reader's to check.
Status check_video_meta(const GstVideoInfo& video, const GstVideoMeta& meta);
// Of a buffer without metadata. FRAME_SIZE unless its bytes are one frame of the caps, with rows as
// GStreamer pads them: shorter ones cannot be mapped, longer ones lose a frame.
Status check_video_size(const GstVideoInfo& video, size_t bytes);

}  // namespace weir::gst
