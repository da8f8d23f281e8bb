// SPDX-License-Identifier: LGPL-2.1-or-later
#include "try/photo_direction.hpp"

#include <gst/tag/tag.h>
#include <gst/video/video.h>

#include <fstream>
#include <iterator>
#include <optional>
#include <string_view>

#include "gstcpp/element/ref.hpp"

namespace weir::app {
namespace {

// The TIFF data of the first Exif segment before the pixels.
std::optional<std::string_view> find_exif(std::string_view jpeg) {
  constexpr std::string_view kExif("Exif\0\0", 6);
  constexpr unsigned kApplication1 = 0xE1, kStartOfScan = 0xDA;
  const auto at = [&](size_t i) -> unsigned { return static_cast<unsigned char>(jpeg[i]); };
  if (!jpeg.starts_with("\xFF\xD8")) return std::nullopt;
  // A segment is FF, its kind, and its length with the two bytes of the length.
  for (size_t segment = 2; segment + 4 <= jpeg.size() && at(segment) == 0xFF;) {
    const size_t length = at(segment + 2) << 8 | at(segment + 3);
    if (at(segment + 1) == kStartOfScan || length < 2) return std::nullopt;
    const std::string_view data = jpeg.substr(segment + 4).substr(0, length - 2);
    if (at(segment + 1) == kApplication1 && data.starts_with(kExif))
      return data.substr(kExif.size());
    segment += 2 + length;
  }
  return std::nullopt;
}

}  // namespace

std::string photo_direction(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(file)), {});
  const auto exif = find_exif(bytes);
  if (!exif || exif->empty()) return "";
  const auto buffer = gst::Ref<GstBuffer>::adopt(gst_buffer_new_memdup(exif->data(), exif->size()));
  const gst::Unique<GstTagList, gst_tag_list_unref> tags(
      gst_tag_list_from_exif_buffer_with_tiff_header(buffer.get()));
  GstVideoOrientationMethod method = GST_VIDEO_ORIENTATION_IDENTITY;
  if (!tags || !gst_video_orientation_from_tag(tags.get(), &method) ||
      method == GST_VIDEO_ORIENTATION_IDENTITY)
    return "";
  constexpr const char* kNames[] = {"identity", "90r",  "180",   "90l",
                                    "horiz",    "vert", "ul-lr", "ur-ll"};
  return kNames[method];
}

}  // namespace weir::app
