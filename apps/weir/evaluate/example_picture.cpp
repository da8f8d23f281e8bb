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

const char* name_of(PictureMark::Kind kind) {
  switch (kind) {
    case PictureMark::Kind::Truth:
      return "truth";
    case PictureMark::Kind::Missed:
      return "missed";
    case PictureMark::Kind::Right:
      return "right";
    case PictureMark::Kind::False:
      return "false";
  }
  return "";
}

std::string rect_of(const std::string& attribute, const evaluate::Rectangle& box) {
  return "<rect" + attribute + " x=\"" + fixed(box.x, 1) + "\" y=\"" + fixed(box.y, 1) +
         "\" width=\"" + fixed(box.width, 1) + "\" height=\"" + fixed(box.height, 1) + "\"/>";
}

// The labels of a picture. They stay inside it, and none covers another while there is place.
class Labels {
 public:
  static constexpr double kLine = 17;  // the height of a label

  Labels(double width, double height) : width_(width), height_(height) {}

  std::string add(const std::string& kind, const std::string& text, double x, double y) {
    const evaluate::Rectangle place = free_place(text, x, y);
    placed_.push_back(place);
    return "<g class=\"label " + kind + "\">" + rect_of("", place) + "<text x=\"" +
           fixed(place.x + kMargin, 1) + "\" y=\"" + fixed(place.y + kLine - kMargin - 1, 1) +
           "\">" + escaped(text) + "</text></g>\n";
  }

 private:
  static constexpr double kLetter = 7.6, kMargin = 3;  // of letters 13 pixels high

  evaluate::Rectangle free_place(const std::string& text, double x, double y) const {
    const auto letters = static_cast<double>(g_utf8_strlen(text.c_str(), -1));
    evaluate::Rectangle place{0, 0, letters * kLetter + 2 * kMargin, kLine};
    place.x = std::clamp(x, 0.0, std::max(0.0, width_ - place.width));
    place.y = std::clamp(y, 0.0, std::max(0.0, height_ - kLine));
    const auto covers = [&place](const auto& other) {
      return place.x < other.x + other.width && other.x < place.x + place.width &&
             place.y < other.y + other.height && other.y < place.y + place.height;
    };
    const auto begin = place;
    for (const double step : {kLine, -kLine}) {  // downwards, and where that leaves it, upwards
      place = begin;
      while (place.y >= 0 && place.y + kLine <= height_) {
        const auto other = std::find_if(placed_.begin(), placed_.end(), covers);
        if (other == placed_.end()) return place;
        place.y = other->y + step;
      }
    }
    return begin;
  }

  const double width_, height_;
  std::vector<evaluate::Rectangle> placed_;
};

// Boxes and points over a dark edge, so that they are seen on every background, then the labels.
// `scale`: pixels of the page for each of the picture.
std::string svg_of(const std::vector<PictureMark>& shapes, double scale, Labels labels) {
  constexpr double kRadius = 3.2;
  std::string edges, boxes, texts;
  for (const PictureMark& shape : shapes) {
    const std::string kind = name_of(shape.kind);
    const evaluate::Rectangle box{shape.box.x * scale, shape.box.y * scale, shape.box.width * scale,
                                  shape.box.height * scale};
    edges += rect_of(" class=\"edge\"", box);
    boxes += rect_of(" class=\"" + kind + "\"", box);
    for (const auto& point : shape.points)
      if (point.is_labelled)
        boxes += "<circle class=\"" + kind + "\" cx=\"" + fixed(point.x * scale, 1) + "\" cy=\"" +
                 fixed(point.y * scale, 1) + "\" r=\"" + fixed(kRadius, 1) + "\"/>";
    // Labels of the truth are at the bottom of its box, so that they do not cover those of results.
    const bool is_truth =
        shape.kind == PictureMark::Kind::Truth || shape.kind == PictureMark::Kind::Missed;
    texts +=
        labels.add(kind, shape.label, box.x, is_truth ? box.y + box.height - Labels::kLine : box.y);
  }
  return edges + "\n" + boxes + "\n" + texts;
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
  auto picture = decode_picture(example.path);
  if (!picture) return "";
  if (!example.wrong_pixels.empty()) mark(example.wrong_pixels, &*picture);
  const auto jpeg = small_jpeg(*picture, kMostPixels);
  if (!jpeg) return "";
  const gst::UniqueText base64(
      g_base64_encode(reinterpret_cast<const guchar*>(jpeg->data()), jpeg->size()));
  const uint32_t longer = std::max(picture->width, picture->height);
  const double scale = std::min(1.0, static_cast<double>(kMostPixels) / longer);
  const double width = picture->width * scale, height = picture->height * scale;
  std::string out = "<figure><svg class=\"picture\" viewBox=\"0 0 " + fixed(width, 0) + " " +
                    fixed(height, 0) + "\" width=\"" + fixed(width, 0) + "\" height=\"" +
                    fixed(height, 0) + "\"><image width=\"" + fixed(width, 0) + "\" height=\"" +
                    fixed(height, 0) + "\" href=\"data:image/jpeg;base64," + base64.get() +
                    "\"/>\n";
  out += svg_of(example.shapes, scale, Labels(width, height));
  return out + "</svg><figcaption>" + escaped(example.path) + "<br>" + escaped(example.caption) +
         "</figcaption></figure>\n";
}

}  // namespace weir::app
