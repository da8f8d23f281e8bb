// Plays a short pipeline for each file.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "evaluate/picture_file.hpp"

#include <gst/app/gstappsink.h>
#include <gst/app/gstappsrc.h>
#include <gst/tag/tag.h>
#include <gst/video/video.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <string_view>

#include "core/text/shell_quote.hpp"
#include "evaluate/folder_files.hpp"

namespace weir::app {
namespace {

// The TIFF data of the first Exif segment before the pixels.
std::optional<std::string_view> exif_of(std::string_view jpeg) {
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

// GST_VIDEO_ORIENTATION_IDENTITY for a file that does not say. Some installations of GStreamer have
// no element that reports it (jpegparse).
GstVideoOrientationMethod photo_orientation(const std::filesystem::path& path) {
  GstVideoOrientationMethod out = GST_VIDEO_ORIENTATION_IDENTITY;
  const auto bytes = read_file(path);
  const auto exif = bytes ? exif_of(*bytes) : std::nullopt;
  if (!exif || exif->empty()) return out;
  const auto buffer = gst::Ref<GstBuffer>::adopt(gst_buffer_new_memdup(exif->data(), exif->size()));
  const gst::Unique<GstTagList, gst_tag_list_unref> tags(
      gst_tag_list_from_exif_buffer_with_tiff_header(buffer.get()));
  if (!tags || !gst_video_orientation_from_tag(tags.get(), &out))
    return GST_VIDEO_ORIENTATION_IDENTITY;
  return out;
}

using Sample = gst::Unique<GstSample, gst_sample_unref>;

// A pipeline that makes one frame, which `sink` has. Stops it at the end of the scope.
class OneFrame {
 public:
  explicit OneFrame(const std::string& text) : pipeline_(gst::Ref<GstElement>::adopt(parse(text))) {
    if (pipeline_)
      sink_ = gst::Ref<GstElement>::adopt(gst_bin_get_by_name(GST_BIN(pipeline_.get()), "sink"));
  }
  ~OneFrame() {
    if (pipeline_) gst_element_set_state(pipeline_.get(), GST_STATE_NULL);
  }
  OneFrame(const OneFrame&) = delete;
  OneFrame& operator=(const OneFrame&) = delete;

  gst::Ref<GstElement> element(const char* name) const {
    return gst::Ref<GstElement>::adopt(
        pipeline_ ? gst_bin_get_by_name(GST_BIN(pipeline_.get()), name) : nullptr);
  }
  bool start() {
    return sink_ &&
           gst_element_set_state(pipeline_.get(), GST_STATE_PLAYING) != GST_STATE_CHANGE_FAILURE;
  }
  // Null after an error, or when nothing comes within a minute.
  Sample frame() {
    const auto bus = gst::Ref<GstBus>::adopt(gst_element_get_bus(pipeline_.get()));
    for (int tenths = 0; tenths < kMostTenths; ++tenths) {
      Sample sample(gst_app_sink_try_pull_sample(GST_APP_SINK(sink_.get()), GST_SECOND / 10));
      if (sample) return sample;
      if (read_error(bus.get()) || gst_app_sink_is_eos(GST_APP_SINK(sink_.get()))) break;
    }
    read_error(bus.get());
    return {};
  }
  const std::string& reason() const noexcept { return reason_; }

 private:
  static constexpr int kMostTenths = 600;

  static GstElement* parse(const std::string& text) {
    GError* error = nullptr;
    GstElement* parsed = gst_parse_launch(text.c_str(), &error);
    g_clear_error(&error);
    return parsed ? GST_ELEMENT(gst_object_ref_sink(parsed)) : nullptr;
  }
  bool read_error(GstBus* bus) {
    const auto message = gst::Ref<GstMessage>::adopt(gst_bus_pop_filtered(bus, GST_MESSAGE_ERROR));
    if (!message) return !reason_.empty();
    GError* error = nullptr;
    gst_message_parse_error(message.get(), &error, nullptr);
    if (reason_.empty()) reason_ = error ? error->message : "GStreamer gives no reason";
    g_clear_error(&error);
    return true;
  }

  gst::Ref<GstElement> pipeline_, sink_;
  std::string reason_;
};

Error unreadable(const std::string& path, const std::string& reason) {
  return {.code = Code::FILE_NOT_FOUND,
          .what = "a picture is damaged or has an unknown format",
          .offered = path,
          .needed = "a picture that GStreamer can decode",
          .difference = reason,
          .fix = "replace the file, or delete it and its truth"};
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

Result<ClassMask> classes_of(const GstVideoFrame& frame, const PngFacts& png,
                             const std::string& path) {
  ClassMask out{static_cast<uint32_t>(GST_VIDEO_FRAME_WIDTH(&frame)),
                static_cast<uint32_t>(GST_VIDEO_FRAME_HEIGHT(&frame)),
                {}};
  const auto* pixels = static_cast<const uint8_t*>(GST_VIDEO_FRAME_PLANE_DATA(&frame, 0));
  const auto stride = static_cast<size_t>(GST_VIDEO_FRAME_PLANE_STRIDE(&frame, 0));
  const auto step = static_cast<size_t>(GST_VIDEO_FRAME_COMP_PSTRIDE(&frame, 0));
  const auto red = static_cast<size_t>(GST_VIDEO_FRAME_COMP_POFFSET(&frame, 0));
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
  OneFrame frame(
      "filesrc name=file ! decodebin ! videoconvert ! video/x-raw,format=RGB ! "
      "videoflip name=upright ! "
      "appsink name=sink sync=false");
  if (const auto file = frame.element("file"))
    g_object_set(file.get(), "location", path.c_str(), nullptr);
  if (const auto upright = frame.element("upright"))
    g_object_set(upright.get(), "video-direction", photo_orientation(path), nullptr);
  if (!frame.start()) return unreadable(path, "GStreamer cannot start its decoder");
  const auto sample = frame.frame();
  if (!sample) return unreadable(path, frame.reason());
  GstVideoInfo info;
  GstCaps* caps = gst_sample_get_caps(sample.get());
  if (!caps || !gst_video_info_from_caps(&info, caps)) return unreadable(path, "no size");
  return DecodedPicture{gst::Ref<GstBuffer>::share(gst_sample_get_buffer(sample.get())),
                        gst::Ref<GstCaps>::share(caps), static_cast<uint32_t>(info.width),
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
  OneFrame frame("filesrc name=file ! pngdec ! appsink name=sink sync=false");
  if (const auto file = frame.element("file"))
    g_object_set(file.get(), "location", path.c_str(), nullptr);
  if (!frame.start()) return unreadable(path, "GStreamer cannot start its decoder");
  const auto sample = frame.frame();
  if (!sample) return unreadable(path, frame.reason());
  GstVideoInfo info;
  GstVideoFrame mapped;
  if (!gst_video_info_from_caps(&info, gst_sample_get_caps(sample.get())) ||
      !gst_video_frame_map(&mapped, &info, gst_sample_get_buffer(sample.get()), GST_MAP_READ))
    return unreadable(path, "no pixels");
  auto out = classes_of(mapped, png, path);
  gst_video_frame_unmap(&mapped);
  return out;
}

Result<std::string> small_jpeg(const DecodedPicture& picture, uint32_t most) {
  const uint32_t longer = std::max(picture.width, picture.height);
  const double scale = longer > most ? static_cast<double>(most) / longer : 1;
  const auto scaled = [scale](uint32_t pixels) {
    return std::to_string(std::max(1L, std::lround(pixels * scale)));
  };
  OneFrame frame("appsrc name=source format=time ! videoscale ! videoconvert ! video/x-raw,width=" +
                 scaled(picture.width) + ",height=" + scaled(picture.height) +
                 ",pixel-aspect-ratio=1/1 ! jpegenc quality=85 ! appsink name=sink sync=false");
  const auto source = frame.element("source");
  if (source && frame.start()) {
    gst_app_src_set_caps(GST_APP_SRC(source.get()), picture.caps.get());
    gst_app_src_push_buffer(GST_APP_SRC(source.get()), gst_buffer_copy(picture.buffer.get()));
    gst_app_src_end_of_stream(GST_APP_SRC(source.get()));
    if (const auto sample = frame.frame()) {
      const gst::Mapped bytes(gst_sample_get_buffer(sample.get()), GST_MAP_READ);
      if (bytes)
        return std::string(reinterpret_cast<const char*>(bytes.bytes().data()),
                           bytes.bytes().size());
    }
  }
  return Error{.code = Code::FILE_NOT_WRITTEN,
               .what = "GStreamer cannot encode a picture for the page",
               .offered = frame.reason(),
               .needed = "the element jpegenc",
               .fix = "apt-get install gstreamer1.0-plugins-good"};
}

}  // namespace weir::app
