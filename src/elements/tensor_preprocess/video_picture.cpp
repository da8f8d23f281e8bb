// Reads pictures from GStreamer's memory; rejects what GStreamer would log critical warnings for.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_preprocess/video_picture.hpp"

#include <algorithm>
#include <string>

#include "core/tensor/geometry.hpp"
#include "gstcpp/buffer/mapped_video.hpp"

namespace weir {
namespace {

using preprocess::ColorMatrix;
using preprocess::ColorModel;

Status check_meta(const GstVideoInfo& video, const GstVideoMeta& meta, size_t bytes) {
  if (auto status = gst::check_video_meta(video, meta); !status) return status;
  for (guint plane = 0; plane < meta.n_planes; ++plane)
    if (meta.offset[plane] >= bytes)
      return gst::video_too_small(
          std::to_string(bytes) + " bytes",
          "plane " + std::to_string(plane) + " at byte " + std::to_string(meta.offset[plane]));
  return ok();
}

}  // namespace

Result<preprocess::Picture> make_picture(const GstVideoInfo& video) {
  auto format = preprocess::picture_format(GST_VIDEO_INFO_NAME(&video));
  if (!format) return format.error();
  preprocess::Picture out;
  out.format = *format;
  out.width = static_cast<uint32_t>(GST_VIDEO_INFO_WIDTH(&video));
  out.height = static_cast<uint32_t>(GST_VIDEO_INFO_HEIGHT(&video));
  const GstVideoColorimetry& colors = video.colorimetry;
  const bool yuv = out.format.model == ColorModel::Yuv;
  const bool limited = colors.range == GST_VIDEO_COLOR_RANGE_16_235 ||
                       (yuv && colors.range == GST_VIDEO_COLOR_RANGE_UNKNOWN);
  out.range = limited ? preprocess::ColorRange::Limited : preprocess::ColorRange::Full;
  const auto site = GST_VIDEO_INFO_CHROMA_SITE(&video);
  out.cosited_columns = (site & GST_VIDEO_CHROMA_SITE_H_COSITED) != 0;
  out.cosited_rows = (site & GST_VIDEO_CHROMA_SITE_V_COSITED) != 0;
  if (!yuv) return out;
  switch (colors.matrix) {
    case GST_VIDEO_COLOR_MATRIX_UNKNOWN:
    case GST_VIDEO_COLOR_MATRIX_BT601:
      out.matrix = ColorMatrix::Bt601;
      return out;
    case GST_VIDEO_COLOR_MATRIX_BT709:
      out.matrix = ColorMatrix::Bt709;
      return out;
    case GST_VIDEO_COLOR_MATRIX_BT2020:
      out.matrix = ColorMatrix::Bt2020;
      return out;
    default:
      return Error{.code = Code::FORMAT_UNSUPPORTED,
                   .what = "the colour matrix of the video is not known",
                   .offered = "matrix " + std::to_string(static_cast<int>(colors.matrix)) +
                              " of colorimetry",
                   .needed = "bt601, bt709 or bt2020",
                   .fix = "videoconvert ! video/x-raw,format=RGB ! tensor_preprocess"};
  }
}

CroppedPicture size_of_picture(const GstVideoInfo& video, GstBuffer* buffer) {
  CroppedPicture out{static_cast<uint32_t>(GST_VIDEO_INFO_WIDTH(&video)),
                     static_cast<uint32_t>(GST_VIDEO_INFO_HEIGHT(&video)),
                     {}};
  const GstVideoCropMeta* crop = gst_buffer_get_video_crop_meta(buffer);
  if (!crop) return out;
  out.crop = Rect{crop->x, crop->y, crop->width, crop->height};
  // The crop is relative to the picture in memory, which may be larger than the caps.
  if (const GstVideoMeta* meta = gst_buffer_get_video_meta(buffer)) {
    out.width = meta->width;
    out.height = meta->height;
  }
  return out;
}

Status narrow(CroppedPicture* picture, const std::optional<Rect>& part) {
  if (!part) return ok();
  const auto whole = picture->crop.value_or(Rect{0, 0, picture->width, picture->height});
  preprocess::Picture seen;
  seen.width = whole.width;
  seen.height = whole.height;
  if (auto status = preprocess::check_crop(seen, *part); !status) return status;
  picture->crop = {whole.x + part->x, whole.y + part->y, part->width, part->height};
  return ok();
}

Status MappedPicture::map(const GstVideoInfo& video, GstBuffer* buffer, GstMapFlags flags) {
  const GstVideoMeta* meta = gst_buffer_get_video_meta(buffer);
  const size_t bytes = gst_buffer_get_size(buffer);
  if (meta) {
    if (auto status = check_meta(video, *meta, bytes); !status) return status;
  } else if (auto status = gst::check_video_size(video, bytes); !status) {
    return status.error();
  }
  if (auto status = mapped_.map(video, buffer, flags); !status) return status;
  const size_t planes = std::min<size_t>(GST_VIDEO_INFO_N_PLANES(&video), planes_.size());
  for (size_t i = 0; i < planes; ++i) {
    const auto& plane = mapped_.planes()[i];
    planes_[i] = {plane.bytes, plane.offset, plane.stride};
  }
  return ok();
}

}  // namespace weir
