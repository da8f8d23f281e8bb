// Rows without padding.
#include "elements/tensor_converter/dense_video.hpp"

#include <algorithm>
#include <cstring>

namespace weir {

size_t DenseVideo::frame_bytes() const noexcept {
  return static_cast<size_t>(tensor_.rows) * tensor_.row_bytes;
}

Result<gst::Ref<GstBuffer>> DenseVideo::from(gst::Ref<GstBuffer> buffer, Ledger* ledger) const {
  const GstVideoMeta* meta = gst_buffer_get_video_meta(buffer.get());
  const int64_t stride = meta ? meta->stride[0] : GST_VIDEO_INFO_PLANE_STRIDE(&video_, 0);
  const bool packed = GST_VIDEO_INFO_N_PLANES(&video_) == 1;
  if (packed && stride == static_cast<int64_t>(tensor_.row_bytes) &&
      (!meta || meta->offset[0] == 0) && gst_buffer_get_size(buffer.get()) == frame_bytes())
    return buffer;
  if (!meta && gst_buffer_get_size(buffer.get()) / GST_VIDEO_INFO_SIZE(&video_) > 1)
    return Error{Code::FRAME_SIZE,
                 "a video buffer holds more than one frame",
                 std::to_string(gst_buffer_get_size(buffer.get())) + " bytes",
                 std::to_string(GST_VIDEO_INFO_SIZE(&video_)) + " bytes",
                 "",
                 "rawvideoparse ! tensor_converter"};
  return copy_rows(buffer.get(), ledger);
}

// How far the planes' offsets and strides reach; nullopt when they lead in front of the buffer.
std::optional<size_t> DenseVideo::needed_bytes(GstBuffer* buffer) const {
  const GstVideoMeta* meta = gst_buffer_get_video_meta(buffer);
  const guint planes = GST_VIDEO_INFO_N_PLANES(&video_);
  int64_t needed = 0;
  for (guint plane = 0; plane < planes; ++plane) {
    const size_t offset = meta ? meta->offset[plane] : GST_VIDEO_INFO_PLANE_OFFSET(&video_, plane);
    const int64_t stride = meta ? meta->stride[plane] : GST_VIDEO_INFO_PLANE_STRIDE(&video_, plane);
    if (offset > INT32_MAX) return std::nullopt;
    const auto first = static_cast<int64_t>(offset);
    const int64_t last = first + stride * (static_cast<int64_t>(tensor_.rows / planes) - 1);
    if (last < 0) return std::nullopt;
    needed = std::max(needed, std::max(first, last) + static_cast<int64_t>(tensor_.row_bytes));
  }
  return static_cast<size_t>(needed);
}

Result<gst::Ref<GstBuffer>> DenseVideo::copy_rows(GstBuffer* buffer, Ledger* ledger) const {
  const auto needed = needed_bytes(buffer);
  GstVideoFrame frame;
  if (!needed || gst_buffer_get_size(buffer) < *needed ||
      !gst_video_frame_map(&frame, &video_, buffer, GST_MAP_READ))
    return Error{Code::FRAME_SIZE,
                 "a video buffer is shorter than its caps say",
                 std::to_string(gst_buffer_get_size(buffer)) + " bytes",
                 needed ? std::to_string(*needed) + " bytes" : "offsets and strides within it",
                 "",
                 "check the element before"};
  auto out = gst::Ref<GstBuffer>::adopt(gst_buffer_new_allocate(nullptr, frame_bytes(), nullptr));
  if (!out) {
    gst_video_frame_unmap(&frame);
    return Error{Code::OUT_OF_MEMORY, "no memory for an output buffer", "", "", "", ""};
  }
  {
    const gst::Mapped map(out.get(), GST_MAP_WRITE);
    std::byte* to = map.bytes().data();
    const guint planes = GST_VIDEO_FRAME_N_PLANES(&frame);
    for (guint plane = 0; plane < planes; ++plane) {
      const auto* from = static_cast<const std::byte*>(GST_VIDEO_FRAME_PLANE_DATA(&frame, plane));
      const ptrdiff_t stride = GST_VIDEO_FRAME_PLANE_STRIDE(&frame, plane);
      for (uint32_t row = 0; row < tensor_.rows / planes; ++row, to += tensor_.row_bytes)
        std::memcpy(to, from + static_cast<ptrdiff_t>(row) * stride, tensor_.row_bytes);
    }
  }
  gst_video_frame_unmap(&frame);
  gst_buffer_copy_into(out.get(), buffer, GST_BUFFER_COPY_TIMESTAMPS, 0, static_cast<gsize>(-1));
  ledger->copied(frame_bytes());
  return out;
}

}  // namespace weir
