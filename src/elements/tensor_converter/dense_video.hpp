// DenseVideo: video frames with contiguous rows, as a tensor requires.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/video/video.h>

#include <optional>

#include "core/convert/video_tensor.hpp"
#include "core/ledger/ledger.hpp"
#include "gstcpp/buffer/deferred_memory.hpp"
#include "gstcpp/buffer/frame_pool.hpp"
#include "weir/result.hpp"

namespace weir {

class DenseVideo {
 public:
  DenseVideo() = default;
  DenseVideo(const GstVideoInfo& video, const VideoTensor& tensor)
      : video_(video), tensor_(tensor) {}

  size_t frame_bytes() const noexcept;
  // Sets the allocation of later copies; the default is 64-byte alignment.
  void allocate_as(const gst::Allocation& allocation);
  // Outputs padded frames as deferred memory until one is mapped; null: always copies.
  void defer_with(std::shared_ptr<gst::DeferredCounts> counts);
  // Returns the buffer itself if it is dense, else a view or a copy (counted in `ledger`) with its
  // metadata.
  // FORMAT_UNSUPPORTED when the metadata describes another picture; FRAME_SIZE when the buffer is
  // shorter than its offsets and strides require, or holds several frames; OUT_OF_MEMORY.
  Result<gst::Ref<GstBuffer>> from(gst::Ref<GstBuffer> buffer, Ledger* ledger);

 private:
  bool is_dense(GstBuffer* buffer) const noexcept;
  // In bytes, from the buffer's meta, or the caps without one.
  size_t plane_offset(const GstVideoMeta* meta, guint plane) const noexcept;
  int64_t plane_stride(const GstVideoMeta* meta, guint plane) const noexcept;
  Result<gst::Ref<GstBuffer>> pooled();
  std::optional<size_t> needed_bytes(GstBuffer* buffer) const;
  TensorSpec frame_tensor() const;
  std::optional<StridedLayout> find_layout(const GstVideoMeta* meta) const;
  // Null when a view is not possible.
  gst::Ref<GstBuffer> make_view(GstBuffer* buffer);
  Result<gst::Ref<GstBuffer>> copy_rows(GstBuffer* buffer, Ledger* ledger);

  GstVideoInfo video_{};
  VideoTensor tensor_;
  gst::Allocation allocation_;
  std::shared_ptr<gst::DeferredCounts> counts_;  // null: no views
  uint64_t computed_before_ = 0;
  std::shared_ptr<const transform::TransformPlan> view_;  // of frames with view_layout_
  StridedLayout view_layout_;
  gst::FramePool pool_;  // made for the first copy
};

}  // namespace weir
