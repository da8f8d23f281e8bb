// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_overlay/overlay_video.hpp"

#include "elements/tensor_preprocess/video_picture.hpp"

namespace weir {
namespace {

Error overlay_error(Error error) {
  error.what = "tensor_overlay cannot draw into pictures of this format";
  error.fix = "videoconvert ! tensor_overlay";
  return error;
}

// Replaces an unknown matrix; the drawn colours are slightly off then.
GstVideoInfo with_known_matrix(GstVideoInfo video) {
  switch (video.colorimetry.matrix) {
    case GST_VIDEO_COLOR_MATRIX_UNKNOWN:
    case GST_VIDEO_COLOR_MATRIX_BT601:
    case GST_VIDEO_COLOR_MATRIX_BT709:
    case GST_VIDEO_COLOR_MATRIX_BT2020:
      break;
    default:
      video.colorimetry.matrix = GST_VIDEO_COLOR_MATRIX_BT709;
  }
  return video;
}

}  // namespace

Status check_drawable(const GstCaps* caps) {
  if (gst_caps_is_any(caps) || gst_caps_is_empty(caps)) return ok();
  const GstStructure* first = gst_caps_get_structure(caps, 0);
  const char* format = gst_structure_get_string(first, "format");
  if (!format || !gst_structure_has_name(first, "video/x-raw")) return ok();
  const auto known = preprocess::picture_format(format);
  if (known) return ok();
  return overlay_error(known.error());
}

Result<OverlayVideo> OverlayVideo::make(const GstCaps* caps, draw::ClassNames names,
                                        bool show_scores,
                                        std::shared_ptr<draw::TextPainter> painter) {
  GstVideoInfo video;
  if (!gst_video_info_from_caps(&video, caps))
    return Error{.code = Code::FORMAT_UNSUPPORTED, .what = "the video caps cannot be read"};
  const auto picture = make_picture(with_known_matrix(video));
  if (!picture) return overlay_error(picture.error());
  OverlayVideo out(video, *picture);
  if (painter)
    out.labels_ = std::make_unique<draw::Labels>(std::move(names), show_scores, std::move(painter),
                                                 picture->format);
  return out;
}

Result<draw::Drawn> OverlayVideo::draw(const draw::Detections& detections, const draw::Style& style,
                                       const draw::Trails* trails, GstBuffer* buffer,
                                       Ledger* ledger) {
  MappedPicture mapped;
  if (auto status = mapped.map(video_, buffer, GST_MAP_READWRITE); !status) return status.error();
  ledger->copied(mapped.bytes_copied());
  const CroppedPicture size = size_of_picture(video_, buffer);
  picture_.width = size.width;
  picture_.height = size.height;
  draw::Planes planes;
  for (size_t i = 0; i < picture_.format.plane_count(); ++i)
    planes[i] = {mapped.writable(i), mapped.planes()[i].offset, mapped.planes()[i].stride};
  auto canvas = draw::Canvas::make(picture_, planes);
  if (!canvas) return canvas.error();
  return draw::draw(detections, style, labels_.get(), &*canvas, trails);
}

}  // namespace weir
