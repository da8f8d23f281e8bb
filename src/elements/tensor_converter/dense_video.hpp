// DenseVideo: video frames whose rows lie without gaps, as a tensor's do.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/video/video.h>

#include <optional>

#include "core/convert/video_tensor.hpp"
#include "core/ledger/ledger.hpp"
#include "gstcpp/deferred_memory.hpp"
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
  // Frames that are not dense leave as deferred memory, until somebody maps one; null: as copies.
  void defer_with(std::shared_ptr<gst::DeferredCounts> counts);
  // The buffer itself where it is dense; else a view of it or a copy, which is counted in `ledger`,
  // with its metadata.
  // FORMAT_UNSUPPORTED when its metadata are of another picture; FRAME_SIZE when the buffer is
  // shorter than offsets and strides say, or holds several frames; OUT_OF_MEMORY.
  Result<gst::Ref<GstBuffer>> from(gst::Ref<GstBuffer> buffer, Ledger* ledger);

 private:
  bool is_dense(GstBuffer* buffer) const noexcept;
  // As the buffer's meta says, else the caps; bytes.
  size_t plane_offset(const GstVideoMeta* meta, guint plane) const noexcept;
  int64_t plane_stride(const GstVideoMeta* meta, guint plane) const noexcept;
  Result<gst::Ref<GstBuffer>> pooled();
  std::optional<size_t> needed_bytes(GstBuffer* buffer) const;
  TensorSpec frame_tensor() const;
  std::optional<StridedLayout> layout_of(const GstVideoMeta* meta) const;
  // Null where the memory is no view.
  gst::Ref<GstBuffer> view_of(GstBuffer* buffer);
  Result<gst::Ref<GstBuffer>> copy_rows(GstBuffer* buffer, Ledger* ledger);

  GstVideoInfo video_{};
  VideoTensor tensor_;
  gst::Allocation allocation_;
  std::shared_ptr<gst::DeferredCounts> counts_;  // null: no views
  uint64_t computed_before_ = 0;
  std::shared_ptr<const transform::Plan> view_;  // of frames with view_layout_
  StridedLayout view_layout_;
  gst::FramePool pool_;  // made when the first frame must be copied
};

}  // namespace weir
