// DenseVideo: video frames whose rows lie without gaps, as a tensor's do.
#pragma once
#include <gst/video/video.h>

#include <optional>

#include "core/convert/video_tensor.hpp"
#include "core/ledger/ledger.hpp"
#include "gstcpp/ref.hpp"
#include "weir/result.hpp"

namespace weir {

class DenseVideo {
 public:
  DenseVideo() = default;
  DenseVideo(const GstVideoInfo& video, const VideoTensor& tensor)
      : video_(video), tensor_(tensor) {}

  size_t frame_bytes() const noexcept;
  // The buffer itself where it is dense; else a copy with its time-stamps, counted in `ledger`.
  // FRAME_SIZE when the buffer is shorter than offsets and strides say, or holds several frames;
  // OUT_OF_MEMORY.
  Result<gst::Ref<GstBuffer>> from(gst::Ref<GstBuffer> buffer, Ledger* ledger) const;

 private:
  std::optional<size_t> needed_bytes(GstBuffer* buffer) const;
  Result<gst::Ref<GstBuffer>> copy_rows(GstBuffer* buffer, Ledger* ledger) const;

  GstVideoInfo video_{};
  VideoTensor tensor_;
};

}  // namespace weir
