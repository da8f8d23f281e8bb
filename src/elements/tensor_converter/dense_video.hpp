// DenseVideo: video frames whose rows lie without gaps, as a tensor's do.
#pragma once
#include <gst/video/video.h>

#include <optional>

#include "core/convert/video_tensor.hpp"
#include "core/ledger/ledger.hpp"
#include "gstcpp/frame_pool.hpp"
#include "weir/result.hpp"

namespace weir {

class DenseVideo {
 public:
  DenseVideo() = default;
  DenseVideo(const GstVideoInfo& video, const VideoTensor& tensor)
      : video_(video), tensor_(tensor) {}

  size_t frame_bytes() const noexcept;
  // How copies are allocated; at the first of them, 64 bytes without a call.
  void allocate_as(const gst::Allocation& allocation);
  // The buffer itself where it is dense; else a copy with its metadata, counted in `ledger`.
  // FRAME_SIZE when the buffer is shorter than offsets and strides say, or holds several frames;
  // OUT_OF_MEMORY.
  Result<gst::Ref<GstBuffer>> from(gst::Ref<GstBuffer> buffer, Ledger* ledger);

 private:
  bool is_dense(GstBuffer* buffer) const noexcept;
  // As the buffer's meta says, else the caps; bytes.
  size_t plane_offset(const GstVideoMeta* meta, guint plane) const noexcept;
  int64_t plane_stride(const GstVideoMeta* meta, guint plane) const noexcept;
  gst::Ref<GstBuffer> pooled();
  std::optional<size_t> needed_bytes(GstBuffer* buffer) const;
  Result<gst::Ref<GstBuffer>> copy_rows(GstBuffer* buffer, Ledger* ledger);

  GstVideoInfo video_{};
  VideoTensor tensor_;
  gst::Allocation allocation_;
  gst::FramePool pool_;  // made when the first frame must be copied
};

}  // namespace weir
