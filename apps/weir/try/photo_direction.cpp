// SPDX-License-Identifier: LGPL-2.1-or-later
#include "try/photo_direction.hpp"

#include <gst/tag/tag.h>
#include <gst/video/video.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string_view>
#include <system_error>

#include "gstcpp/element/ref.hpp"

namespace weir::app {
namespace {

constexpr std::string_view kJpeg = "\xFF\xD8", kPng = "\x89PNG\r\n\x1A\n", kRiff = "RIFF";
constexpr std::string_view kExif("Exif\0\0", 6);
constexpr size_t kMaxBytes = size_t{1} << 20;

std::string read_bytes(std::ifstream* file, size_t count) {
  std::string bytes(count, '\0');
  file->read(bytes.data(), static_cast<std::streamsize>(count));
  bytes.resize(static_cast<size_t>(file->gcount()));
  return bytes;
}

struct ChunkHead {
  std::string kind;
  uint32_t length = 0;
};
// A length and a kind in PNG, a kind and a length in WebP; nullopt at the end.
std::optional<ChunkHead> read_head(std::ifstream* file, bool is_png) {
  const std::string head = read_bytes(file, 8);
  if (head.size() < 8) return std::nullopt;
  ChunkHead out{head.substr(is_png ? 4 : 0, 4)};
  for (size_t byte = 0; byte < 4; ++byte)
    out.length = out.length << 8 | static_cast<unsigned char>(head[is_png ? byte : 7 - byte]);
  return out;
}

// The chunk with the Exif data of a PNG or WebP file, which may follow the pixels; "" without one.
std::string read_chunk(std::ifstream* file, bool is_png) {
  constexpr int kMaxChunks = 4096;
  for (int i = 0; i < kMaxChunks; ++i) {
    const auto head = read_head(file, is_png);
    if (!head) return "";
    if (head->kind == (is_png ? "eXIf" : "EXIF"))
      return head->length <= kMaxBytes ? read_bytes(file, head->length) : "";
    // A checksum follows in PNG, and a byte after an odd length in WebP.
    file->seekg(std::streamoff{head->length} + (is_png ? 4 : head->length % 2), std::ios::cur);
  }
  return "";
}

// The TIFF data of the first Exif segment before the pixels.
std::optional<std::string_view> find_exif(std::string_view jpeg) {
  constexpr unsigned kApplication1 = 0xE1, kStartOfScan = 0xDA;
  const auto at = [&](size_t i) -> unsigned { return static_cast<unsigned char>(jpeg[i]); };
  // A segment is FF, its kind, and its length with the two bytes of the length. Further FF may come
  // before the kind.
  for (size_t segment = kJpeg.size(); segment + 4 <= jpeg.size() && at(segment) == 0xFF;) {
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

// The TIFF data in a file; "" for files of other kinds. A video may be large, and a pipe can be
// read only once.
std::string read_exif(const std::string& path) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return "";
  std::ifstream file(path, std::ios::binary);
  const std::string start = read_bytes(&file, 12);
  const bool is_png = start.starts_with(kPng);
  if (start.starts_with(kJpeg)) {  // in one of the first segments
    const std::string bytes = start + read_bytes(&file, kMaxBytes);
    return std::string(find_exif(bytes).value_or(""));
  }
  if (!is_png && !(start.starts_with(kRiff) && start.ends_with("WEBP"))) return "";
  file.seekg(static_cast<std::streamoff>(is_png ? kPng.size() : start.size()));
  const std::string chunk = read_chunk(&file, is_png);
  return chunk.starts_with(kExif) ? chunk.substr(kExif.size()) : chunk;
}

}  // namespace

std::string photo_direction(const std::string& path) {
  const std::string exif = read_exif(path);
  if (exif.empty()) return "";
  const auto buffer = gst::Ref<GstBuffer>::adopt(gst_buffer_new_memdup(exif.data(), exif.size()));
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
