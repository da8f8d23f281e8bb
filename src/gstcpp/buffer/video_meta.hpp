// Checks the metadata and the size of a video buffer against its caps.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/video/video.h>

#include <string>

#include "weir/result.hpp"

namespace weir::gst {

// FORMAT_UNSUPPORTED unless the metadata describes a picture of the caps' format and of at least
// its size: GStreamer's own mapping logs a critical warning for others. The reader checks offsets
// and strides.
Status check_video_meta(const GstVideoInfo& video, const GstVideoMeta& meta);
// For a buffer without metadata. FRAME_SIZE unless its size is one frame of the caps with
// GStreamer's row padding: a shorter one cannot be mapped, a longer one would lose data.
Status check_video_size(const GstVideoInfo& video, size_t bytes);
// FRAME_SIZE: the buffer is too small for its caps or metadata.
Error video_too_small(std::string offered, std::string needed);

}  // namespace weir::gst
