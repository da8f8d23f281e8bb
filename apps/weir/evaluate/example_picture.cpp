// Puts boxes over pictures.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "evaluate/example_picture.hpp"

#include <glib.h>
#include <gst/video/video.h>

#include <algorithm>

#include "gstcpp/element/ref.hpp"
#include "run/html.hpp"

namespace weir::app {
namespace {

const char* name_of(Shape::Kind kind) {
  switch (kind) {
    case Shape::Kind::Truth:
      return "truth";
    case Shape::Kind::Missed:
      return "missed";
    case Shape::Kind::Right:
      return "right";
    case Shape::Kind::False:
      return "false";
  }
  return "";
}

// `size`: of the text, in pixels of the picture.
std::string svg_of(const Shape& shape, double size) {
  const std::string kind = name_of(shape.kind);
  const auto& box = shape.box;
  std::string out = "<rect class=\"" + kind + "\" x=\"" + fixed(box.x, 1) + "\" y=\"" +
                    fixed(box.y, 1) + "\" width=\"" + fixed(box.width, 1) + "\" height=\"" +
                    fixed(box.height, 1) + "\"/>";
  for (const auto& point : shape.points)
    if (point.is_labelled)
      out += "<circle class=\"" + kind + "\" cx=\"" + fixed(point.x, 1) + "\" cy=\"" +
             fixed(point.y, 1) + "\" r=\"" + fixed(size / 5, 1) + "\"/>";
  // Labels of the truth are at the bottom of its box, so that they do not cover those of results.
  const bool is_truth = shape.kind == Shape::Kind::Truth || shape.kind == Shape::Kind::Missed;
  const double y = is_truth ? box.y + box.height - size / 4 : std::max(box.y + size, size);
  return out + "<text x=\"" + fixed(box.x + size / 4, 1) + "\" y=\"" + fixed(y, 1) +
         "\" style=\"font-size:" + fixed(size, 1) + "px\">" + escaped(shape.label) + "</text>\n";
}

// Mixes red into the wrong pixels of a copy.
void mark(const std::vector<bool>& wrong, DecodedPicture* picture) {
  GstVideoInfo info;
  GstVideoFrame frame;
  auto copy = gst::Ref<GstBuffer>::adopt(gst_buffer_copy_deep(picture->buffer.get()));
  if (wrong.size() != size_t{picture->width} * picture->height ||
      !gst_video_info_from_caps(&info, picture->caps.get()) ||
      !gst_video_frame_map(&frame, &info, copy.get(), GST_MAP_READWRITE))
    return;
  auto* pixels = static_cast<uint8_t*>(GST_VIDEO_FRAME_PLANE_DATA(&frame, 0));
  const auto stride = static_cast<size_t>(GST_VIDEO_FRAME_PLANE_STRIDE(&frame, 0));
  constexpr size_t kStep = 3;
  for (uint32_t y = 0; y < picture->height; ++y)
    for (uint32_t x = 0; x < picture->width; ++x) {
      if (!wrong[size_t{y} * picture->width + x]) continue;
      uint8_t* pixel = pixels + y * stride + kStep * x;
      pixel[0] = static_cast<uint8_t>((pixel[0] + 2 * 255) / 3);
      pixel[1] /= 3;
      pixel[2] /= 3;
    }
  gst_video_frame_unmap(&frame);
  picture->buffer = std::move(copy);
}

}  // namespace

std::string example_picture(const Example& example) {
  constexpr uint32_t kMostPixels = 640;
  constexpr double kTextParts = 40;
  auto picture = decode_picture(example.path);
  if (!picture) return "";
  if (!example.wrong_pixels.empty()) mark(example.wrong_pixels, &*picture);
  const auto jpeg = small_jpeg(*picture, kMostPixels);
  if (!jpeg) return "";
  const gst::UniqueText base64(
      g_base64_encode(reinterpret_cast<const guchar*>(jpeg->data()), jpeg->size()));
  const uint32_t longer = std::max(picture->width, picture->height);
  const double scale = std::min(1.0, static_cast<double>(kMostPixels) / longer);
  const std::string width = std::to_string(picture->width),
                    height = std::to_string(picture->height);
  std::string out = "<figure><svg class=\"picture\" viewBox=\"0 0 " + width + " " + height +
                    "\" width=\"" + fixed(picture->width * scale, 0) + "\" height=\"" +
                    fixed(picture->height * scale, 0) + "\"><image width=\"" + width +
                    "\" height=\"" + height + "\" href=\"data:image/jpeg;base64," + base64.get() +
                    "\"/>\n";
  for (const Shape& shape : example.shapes) out += svg_of(shape, longer / kTextParts);
  return out + "</svg><figcaption>" + escaped(example.path) + "<br>" + escaped(example.caption) +
         "</figcaption></figure>\n";
}

}  // namespace weir::app
