// Converts raw video to tensors (docs/compatibility/converter.md 2.3).
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_converter/video_medium.hpp"

#include "gstcpp/buffer/tensor_caps.hpp"
#include "gstcpp/element/log.hpp"

namespace weir {

Result<StreamPlan> VideoMedium::configure(const GstCaps* caps, const Preferences& preferences) {
  GstVideoInfo video;
  if (!gst_video_info_from_caps(&video, caps)) {
    const gst::UniqueText text{gst_caps_to_string(caps)};
    return Error{.code = Code::FORMAT_UNSUPPORTED,
                 .what = "the video caps cannot be read",
                 .offered = text.get(),
                 .needed = "a format, a width and a height",
                 .fix = "videoconvert ! video/x-raw,format=RGB ! tensor_converter"};
  }
  if (GST_VIDEO_INFO_IS_INTERLACED(&video))
    return Error{
        .code = Code::FORMAT_UNSUPPORTED,
        .what = "interlaced video is not supported",
        .offered = gst_video_interlace_mode_to_string(GST_VIDEO_INFO_INTERLACE_MODE(&video)),
        .needed = "interlace-mode=progressive",
        .fix = "deinterlace ! tensor_converter"};
  auto tensor = video_tensor(
      GST_VIDEO_INFO_NAME(&video), static_cast<uint32_t>(GST_VIDEO_INFO_WIDTH(&video)),
      static_cast<uint32_t>(GST_VIDEO_INFO_HEIGHT(&video)), preferences.frames_per_tensor);
  if (!tensor) return tensor.error();
  if (GST_VIDEO_INFO_VIEWS(&video) > 1)
    GST_CAT_WARNING(gst::library_category(),
                    "the video has several views: each frame is treated as one picture");
  video_ = DenseVideo(video, *tensor);
  StreamPlan plan;
  plan.spec.format = Format::Static;
  plan.spec.tensors = {tensor->spec};
  plan.spec.rate = get_rate(caps);
  plan.frame_bytes = video_.frame_bytes();
  plan.frames_out = preferences.frames_per_tensor;
  plan.picture = picture_as_it_is(static_cast<uint32_t>(GST_VIDEO_INFO_WIDTH(&video)),
                                  static_cast<uint32_t>(GST_VIDEO_INFO_HEIGHT(&video)),
                                  GST_VIDEO_INFO_N_PLANES(&video) > 1);
  if (auto status = agree(plan.spec, preferences.tensors, "video"); !status) return status.error();
  return plan;
}

Result<MediumFrames> VideoMedium::frames(gst::Ref<GstBuffer> buffer, Ledger* ledger) {
  auto dense = video_.from(std::move(buffer), ledger);
  if (!dense) return dense.error();
  return MediumFrames{*std::move(dense), {}, {}};
}

void VideoMedium::allocate_as(const gst::Allocation& wanted) {
  allocation_ = wanted;
  video_.allocate_as(wanted);
}

// Strides and offsets are read from the buffers. If a decoder's rows are dense, it can write into
// memory that is passed on to the engine.
void VideoMedium::offer(GstQuery* query) const {
  gst_query_add_allocation_meta(query, GST_VIDEO_META_API_TYPE, nullptr);
  GstCaps* caps = nullptr;
  gboolean need_pool = FALSE;
  gst_query_parse_allocation(query, &caps, &need_pool);
  GstVideoInfo video;
  if (!need_pool || !caps || !gst_video_info_from_caps(&video, caps) ||
      GST_VIDEO_INFO_SIZE(&video) != video_.frame_bytes())
    return;
  const auto pool = gst::Ref<GstBufferPool>::adopt(gst_video_buffer_pool_new());
  GstStructure* config = gst_buffer_pool_get_config(pool.get());
  const auto size = static_cast<guint>(GST_VIDEO_INFO_SIZE(&video));
  const auto params = allocation_.params();
  gst_buffer_pool_config_set_params(config, caps, size, 0, 0);
  gst_buffer_pool_config_set_allocator(config, allocation_.allocator.get(), &params);
  if (gst_buffer_pool_set_config(pool.get(), config))
    gst_query_add_allocation_pool(query, pool.get(), size, 0, 0);
}

std::string VideoMedium::caps_for(const TensorSpec& peer, const Fraction& rate) {
  const Shape& d = peer.shape;
  const char* formats = d[0] == 1   ? "{ GRAY8, GRAY16_BE, GRAY16_LE }"
                        : d[0] == 3 ? "RGB"
                        : d[0] == 4 ? "{ RGBx, BGRx, xRGB, xBGR, RGBA, BGRA, ARGB, ABGR }"
                                    : nullptr;
  const std::string framerate = rate.valid()
                                    ? "framerate=(fraction)" + std::to_string(rate.numerator) +
                                          "/" + std::to_string(rate.denominator)
                                    : WEIR_CAPS_RATE;
  std::string text;
  const auto add = [&](const char* list, uint32_t width, uint32_t height) {
    if (width == 0 || height == 0 || width > G_MAXINT || height > G_MAXINT) return;
    text += std::string("video/x-raw, format=(string)") + list + ", width=(int)" +
            std::to_string(width) + ", height=(int)" + std::to_string(height) + ", " + framerate +
            ", interlace-mode=(string)progressive; ";
  };
  if (formats) add(formats, d[1], d[2]);
  if (d[0] == 3) add("BGR", d[1], d[2]);  // second: models are usually trained with RGB
  if (d[2] == 3) add("{ RGBP, BGRP }", d[0], d[1]);
  return text;
}

}  // namespace weir
