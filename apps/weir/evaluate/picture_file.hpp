// Pictures of files as pixels, and pixels as JPEG.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <cstdint>
#include <string>
#include <vector>

#include "gstcpp/element/ref.hpp"
#include "weir/result.hpp"

namespace weir::app {

struct DecodedPicture {
  std::vector<uint8_t> pixels;  // RGB, rows as GStreamer aligns them
  gst::Ref<GstCaps> caps;
  uint32_t width = 0, height = 0;
};

// FILE_NOT_FOUND, with the decoder's reason, for files that are damaged or no pictures.
Result<DecodedPicture> decode_picture(const std::string& path);

struct ClassMask {
  uint32_t width = 0, height = 0;
  std::vector<uint32_t> classes;
};
// The class of each pixel of a PNG file: the index of a palette, or the value of a grey pixel.
// LABELS_INVALID for other files, FILE_NOT_FOUND for damaged ones.
Result<ClassMask> read_class_mask(const std::string& path);

// A JPEG file of at most `max` pixels on the longer side. "" if GStreamer has no encoder.
std::string small_jpeg(const DecodedPicture& picture, uint32_t max);

}  // namespace weir::app
