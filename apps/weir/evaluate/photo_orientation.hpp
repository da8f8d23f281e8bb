// How a photo must be turned to stand upright, by the Exif data of a JPEG file.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/video/video.h>

#include <filesystem>

namespace weir::app {

// GST_VIDEO_ORIENTATION_IDENTITY for a file that does not say. Some installations of GStreamer have
// no element that reports it (jpegparse).
GstVideoOrientationMethod photo_orientation(const std::filesystem::path& path);

}  // namespace weir::app
