// SPDX-License-Identifier: LGPL-2.1-or-later
#include "evaluate/picture_file.hpp"

#include <gst/video/video.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <map>
#include <string_view>

#include "core/text/shell_quote.hpp"
#include "evaluate/folder_files.hpp"
#include "gstcpp/buffer/caps_text.hpp"
#include "try/photo_direction.hpp"
#include "weir/pipeline.hpp"

namespace weir::app {
namespace {

Error unreadable(const std::string& path, const std::string& reason) {
  return {.code = Code::FILE_NOT_FOUND,
          .what = "a picture is damaged or has an unknown format",
          .offered = path,
          .needed = "a picture that GStreamer can decode",
          .difference = reason,
          .fix = "replace the file, or delete it and its truth"};
}

// The one frame of a pipeline with a filesrc `file` and an appsink `sink`, by the public API.
Result<Frame> read_frame(const std::string& path, const std::string& text) {
  auto pipeline = Pipeline::parse(text);
  if (!pipeline || !pipeline->set("file", "location", path) || !pipeline->start())
    return unreadable(path, "GStreamer cannot start its decoder");
  auto frame = pipeline->pull("sink", std::chrono::minutes(1));
  if (frame && *frame) return **std::move(frame);
  std::string reason = frame ? "" : frame.error().what;
  const size_t colon = reason.find(": ");  // after the name of the element
  if (colon != std::string::npos) reason.erase(0, colon + 2);
  return unreadable(path, reason);
}

Error no_mask(const std::string& path, std::string what) {
  return {.code = Code::LABELS_INVALID,
          .what = std::move(what),
          .offered = path,
          .needed = "a PNG file with a palette, or with 1 to 16 bits of grey",
          .fix = "save the mask with the class of each pixel as its value"};
}

// What the head of a PNG file says. https://www.w3.org/TR/png-3/
struct PngFacts {
  enum Kind : uint8_t { Grey = 0, Palette = 3 };
  uint8_t bits = 0, kind = 0xFF;
  std::map<uint32_t, uint32_t> index_of_color;  // 0xRRGGBB
  bool has_equal_colors = false;
};

PngFacts png_facts(const std::string& bytes) {
  constexpr size_t kSignature = 8, kChunkHead = 8, kChunk = 12, kBits = 24, kKind = 25;
  PngFacts out;
  if (!bytes.starts_with("\x89PNG\r\n\x1A\n") || bytes.size() < kKind + 1) return out;
  const auto at = [&](size_t i) -> uint32_t { return static_cast<unsigned char>(bytes[i]); };
  out.bits = static_cast<uint8_t>(at(kBits));
  out.kind = static_cast<uint8_t>(at(kKind));
  for (size_t chunk = kSignature; chunk + kChunk <= bytes.size();) {
    const size_t length =
        at(chunk) << 24 | at(chunk + 1) << 16 | at(chunk + 2) << 8 | at(chunk + 3);
    if (length > bytes.size() - chunk - kChunk) break;
    if (bytes.compare(chunk + 4, 4, "PLTE") == 0) {
      for (size_t i = 0; i < length / 3; ++i) {
        const size_t color = chunk + kChunkHead + 3 * i;
        const bool is_new =
            out.index_of_color.emplace(at(color) << 16 | at(color + 1) << 8 | at(color + 2), i)
                .second;
        out.has_equal_colors |= !is_new;
      }
      break;
    }
    chunk += length + kChunk;
  }
  return out;
}

// The value of a pixel of `bits` bits, which decoders widen to 8.
uint32_t narrowed(uint32_t value, unsigned bits) {
  return bits < 8 ? value / (255U / ((1U << bits) - 1)) : value;
}

Result<ClassMask> read_classes(const Frame& frame, const GstVideoInfo& info, const PngFacts& png,
                               const std::string& path) {
  ClassMask out{static_cast<uint32_t>(info.width), static_cast<uint32_t>(info.height), {}};
  const auto* pixels = reinterpret_cast<const uint8_t*>(frame[0].bytes().data());
  const auto stride = static_cast<size_t>(GST_VIDEO_INFO_PLANE_STRIDE(&info, 0));
  const auto step = static_cast<size_t>(GST_VIDEO_INFO_COMP_PSTRIDE(&info, 0));
  const auto red = static_cast<size_t>(GST_VIDEO_INFO_COMP_POFFSET(&info, 0));
  const bool is_grey = png.kind == PngFacts::Grey;
  for (uint32_t y = 0; y < out.height; ++y)
    for (uint32_t x = 0; x < out.width; ++x) {
      const uint8_t* at = pixels + y * stride + x * step;
      if (is_grey) {
        const uint32_t value = png.bits == 16 ? uint32_t{at[0]} << 8 | at[1] : at[red];
        out.classes.push_back(narrowed(value, png.bits));
        continue;
      }
      at += red;
      const auto index =
          png.index_of_color.find(uint32_t{at[0]} << 16 | uint32_t{at[1]} << 8 | at[2]);
      if (index == png.index_of_color.end())
        return no_mask(path, "the mask has a colour that is not in its palette");
      out.classes.push_back(index->second);
    }
  return out;
}

}  // namespace

Result<DecodedPicture> decode_picture(const std::string& path) {
  const std::string direction = photo_direction(path);
  const auto frame = read_frame(
      path, "filesrc name=file ! decodebin ! videoconvert ! video/x-raw,format=RGB ! " +
                (direction.empty() ? "" : "videoflip video-direction=" + direction + " ! ") +
                "appsink name=sink sync=false");
  if (!frame) return frame.error();
  const auto caps = gst::caps_from_text(frame->caps());
  GstVideoInfo info;
  if (!caps || !gst_video_info_from_caps(&info, caps->get())) return unreadable(path, "no size");
  const auto pixels = (*frame)[0].bytes();
  if (pixels.size() < info.size) return unreadable(path, "no pixels");
  const auto* first = reinterpret_cast<const uint8_t*>(pixels.data());
  return DecodedPicture{{first, first + info.size},
                        *caps,
                        static_cast<uint32_t>(info.width),
                        static_cast<uint32_t>(info.height)};
}

Result<ClassMask> read_class_mask(const std::string& path) {
  const auto bytes = read_file(path);
  if (!bytes) return bytes.error();
  const PngFacts png = png_facts(*bytes);
  if (png.kind != PngFacts::Grey && png.kind != PngFacts::Palette)
    return no_mask(path, "the mask is not a PNG file with a class for each pixel");
  if (png.has_equal_colors && png.kind == PngFacts::Palette)
    return no_mask(path, "the palette of the mask has two equal colours");
  const auto frame = read_frame(path, "filesrc name=file ! pngdec ! appsink name=sink sync=false");
  if (!frame) return frame.error();
  const auto caps = gst::caps_from_text(frame->caps());
  GstVideoInfo info;
  if (!caps || !gst_video_info_from_caps(&info, caps->get()) ||
      (*frame)[0].bytes().size() < info.size)
    return unreadable(path, "no pixels");
  return read_classes(*frame, info, png, path);
}

std::string small_jpeg(const DecodedPicture& picture, uint32_t max) {
  const uint32_t longer = std::max(picture.width, picture.height);
  const double scale = longer > max ? static_cast<double>(max) / longer : 1;
  const auto scaled = [scale](uint32_t pixels) {
    return std::to_string(std::max(1L, std::lround(pixels * scale)));
  };
  const gst::UniqueText caps(gst_caps_to_string(picture.caps.get()));
  auto pipeline = Pipeline::parse(
      "appsrc name=source caps=\"" + std::string(caps.get()) +
      "\" ! videoscale ! videoconvert ! video/x-raw,width=" + scaled(picture.width) +
      ",height=" + scaled(picture.height) +
      ",pixel-aspect-ratio=1/1 ! jpegenc quality=85 ! appsink name=sink sync=false");
  if (!pipeline || !pipeline->start()) return "";
  if (!pipeline->push("source", std::span(picture.pixels)) || !pipeline->end("source")) return "";
  const auto frame = pipeline->pull("sink", std::chrono::minutes(1));
  if (!frame || !*frame) return "";
  const auto jpeg = (**frame)[0].bytes();
  return {reinterpret_cast<const char*>(jpeg.data()), jpeg.size()};
}

}  // namespace weir::app
