// SPDX-License-Identifier: LGPL-2.1-or-later
#include "try/photo_direction.hpp"

#include <gst/tag/tag.h>
#include <gst/video/video.h>

#include <filesystem>
#include <fstream>
#include <optional>
#include <string_view>
#include <system_error>

#include "gstcpp/element/ref.hpp"

namespace weir::app {
namespace {

constexpr std::string_view kStart = "\xFF\xD8";

// The first MiB of a JPEG file, which has the Exif data in one of its first segments; "" for every
// other file. A video may be large, and a pipe can be read only once.
std::string read_start(const std::string& path) {
  constexpr std::streamsize kMaxBytes = std::streamsize{1} << 20;
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return "";
  std::ifstream file(path, std::ios::binary);
  std::string bytes(kStart.size(), '\0');
  const auto read = [&file, &bytes](size_t from) {
    file.read(bytes.data() + from, static_cast<std::streamsize>(bytes.size() - from));
    bytes.resize(from + static_cast<size_t>(file.gcount()));
  };
  read(0);
  if (bytes != kStart) return "";
  bytes.resize(kMaxBytes);
  read(kStart.size());
  return bytes;
}

// The TIFF data of the first Exif segment before the pixels.
std::optional<std::string_view> find_exif(std::string_view jpeg) {
  constexpr std::string_view kExif("Exif\0\0", 6);
  constexpr unsigned kApplication1 = 0xE1, kStartOfScan = 0xDA;
  const auto at = [&](size_t i) -> unsigned { return static_cast<unsigned char>(jpeg[i]); };
  // A segment is FF, its kind, and its length with the two bytes of the length. Further FF may come
  // before the kind.
  for (size_t segment = kStart.size(); segment + 4 <= jpeg.size() && at(segment) == 0xFF;) {
    if (at(segment + 1) == 0xFF) {
      ++segment;
      continue;
    }
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
  const std::string bytes = read_start(path);
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
