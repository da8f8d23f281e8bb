// How a photo must be turned to be upright.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

namespace weir::app {

// Returns the value of video-direction of videoflip for a JPEG, PNG or WebP file with an
// orientation in its Exif data, and "" for every other file and for a photo that is upright. Some
// installations of GStreamer have no element that reports the orientation (jpegparse), and decoders
// of PNG and WebP do not.
std::string photo_direction(const std::string& path);

}  // namespace weir::app
