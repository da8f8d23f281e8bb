// SPDX-License-Identifier: LGPL-2.1-or-later
#include "elements/tensor_converter/dense_video.hpp"

#include <algorithm>
#include <cstring>

#include "gstcpp/buffer/frame_errors.hpp"
#include "gstcpp/buffer/mapped_video.hpp"

namespace weir {

size_t DenseVideo::frame_bytes() const noexcept {
  return static_cast<size_t>(tensor_.rows) * tensor_.row_bytes;
}

void DenseVideo::allocate_as(const gst::Allocation& allocation) {
  if (allocation == allocation_) return;
  allocation_ = allocation;
  pool_ = {};
}

size_t DenseVideo::plane_offset(const GstVideoMeta* meta, guint plane) const noexcept {
  return meta ? meta->offset[plane] : GST_VIDEO_INFO_PLANE_OFFSET(&video_, plane);
}
int64_t DenseVideo::plane_stride(const GstVideoMeta* meta, guint plane) const noexcept {
  return meta ? meta->stride[plane] : GST_VIDEO_INFO_PLANE_STRIDE(&video_, plane);
}

bool DenseVideo::is_dense(GstBuffer* buffer) const noexcept {
  if (gst_buffer_get_size(buffer) != frame_bytes()) return false;
  const GstVideoMeta* meta = gst_buffer_get_video_meta(buffer);
  const guint planes = GST_VIDEO_INFO_N_PLANES(&video_);
  for (guint plane = 0; plane < planes; ++plane)
    if (plane_stride(meta, plane) != static_cast<int64_t>(tensor_.row_bytes) ||
        plane_offset(meta, plane) != frame_bytes() / planes * plane)
      return false;
  return true;
}

Result<gst::Ref<GstBuffer>> DenseVideo::from(gst::Ref<GstBuffer> buffer, Ledger* ledger) {
  const GstVideoMeta* meta = gst_buffer_get_video_meta(buffer.get());
  if (meta)
    if (auto status = gst::check_video_meta(video_, *meta); !status) return status.error();
  if (is_dense(buffer.get())) return buffer;
  if (!meta)
    if (auto status = gst::check_video_size(video_, gst_buffer_get_size(buffer.get())); !status)
      return status.error();
  if (auto view = make_view(buffer.get())) return view;
  return copy_rows(buffer.get(), ledger);
}

void DenseVideo::defer_with(std::shared_ptr<gst::DeferredCounts> counts) {
  counts_ = std::move(counts);
  if (counts_) computed_before_ = counts_->computed;
}

TensorSpec DenseVideo::frame_tensor() const {
  TensorSpec frame = tensor_.spec;
  frame.shape[3] = 1;  // without frames-per-tensor
  return frame;
}

// nullopt when the planes are not evenly spaced.
std::optional<StridedLayout> DenseVideo::find_layout(const GstVideoMeta* meta) const {
  const guint planes = GST_VIDEO_INFO_N_PLANES(&video_);
  const auto offset = [&](guint plane) { return static_cast<int64_t>(plane_offset(meta, plane)); };
  StridedLayout out{plane_offset(meta, 0), {}};
  const int64_t row = plane_stride(meta, 0);
  if (planes == 1) {
    const auto bytes = static_cast<int64_t>(element_size(tensor_.spec.type));
    out.strides = {bytes, bytes * tensor_.spec.shape[0], row, 0};
    return out;
  }
  const int64_t apart = offset(1) - offset(0);
  for (guint plane = 1; plane < planes; ++plane)
    if (plane_stride(meta, plane) != row || offset(plane) - offset(plane - 1) != apart)
      return std::nullopt;
  out.strides = {1, row, apart, 0};
  return out;
}

// If deferred memory is being mapped, copying rows into pooled memory is faster: no view then.
gst::Ref<GstBuffer> DenseVideo::make_view(GstBuffer* buffer) {
  if (!counts_ || counts_->computed != computed_before_ || gst_buffer_n_memory(buffer) != 1 ||
      !gst_memory_is_type(gst_buffer_peek_memory(buffer, 0), GST_ALLOCATOR_SYSMEM))
    return {};
  const auto layout = find_layout(gst_buffer_get_video_meta(buffer));
  if (!layout) return {};
  if (!view_ || layout->offset != view_layout_.offset || layout->strides != view_layout_.strides) {
    auto plan = transform::gather_plan(frame_tensor(), *layout);
    if (!plan) return {};  // copy_rows reports the error
    view_ = std::make_shared<const transform::TransformPlan>(*std::move(plan));
    view_layout_ = *layout;
  }
  if (gst_buffer_get_size(buffer) < view_->input().bytes()) return {};
  GstMemory* memory =
      gst::make_deferred_memory({gst::Ref<GstBuffer>::share(buffer), 0, view_}, counts_);
  if (!memory) return {};
  auto out = gst::Ref<GstBuffer>::adopt(gst_buffer_new());
  gst_buffer_append_memory(out.get(), memory);
  gst_buffer_copy_into(out.get(), buffer, GST_BUFFER_COPY_METADATA, 0, static_cast<gsize>(-1));
  return out;
}

// How far the planes' offsets and strides reach; nullopt when they precede the buffer's start.
std::optional<size_t> DenseVideo::needed_bytes(GstBuffer* buffer) const {
  const GstVideoMeta* meta = gst_buffer_get_video_meta(buffer);
  const guint planes = GST_VIDEO_INFO_N_PLANES(&video_);
  int64_t needed = 0;
  for (guint plane = 0; plane < planes; ++plane) {
    const size_t offset = plane_offset(meta, plane);
    const int64_t stride = plane_stride(meta, plane);
    if (offset > INT32_MAX) return std::nullopt;
    const auto first = static_cast<int64_t>(offset);
    const int64_t last = first + stride * (static_cast<int64_t>(tensor_.rows / planes) - 1);
    if (last < 0) return std::nullopt;
    needed = std::max(needed, std::max(first, last) + static_cast<int64_t>(tensor_.row_bytes));
  }
  return static_cast<size_t>(needed);
}

Result<gst::Ref<GstBuffer>> DenseVideo::pooled() {
  if (!pool_) {
    auto pool =
        gst::FramePool::make({frame_tensor()}, Format::Static, MediaType::Tensor, allocation_);
    if (!pool) return pool.error();
    pool_ = *std::move(pool);
  }
  return pool_.acquire();
}

Result<gst::Ref<GstBuffer>> DenseVideo::copy_rows(GstBuffer* buffer, Ledger* ledger) {
  const auto needed = needed_bytes(buffer);
  if (!needed || gst_buffer_get_size(buffer) < *needed)
    return gst::video_too_small(
        std::to_string(gst_buffer_get_size(buffer)) + " bytes",
        needed ? std::to_string(*needed) + " bytes" : "offsets and strides within it");
  gst::MappedVideo picture;
  if (auto status = picture.map(video_, buffer, GST_MAP_READ); !status) return status.error();
  auto out = pooled();
  if (!out) return out;
  {
    const gst::Mapped map(out->get(), GST_MAP_WRITE);
    if (!map) return gst::memory_ran_out(frame_bytes());
    std::byte* to = map.bytes().data();
    const guint planes = GST_VIDEO_INFO_N_PLANES(&video_);
    for (guint i = 0; i < planes; ++i) {
      const auto& plane = picture.planes()[i];
      const std::byte* from = plane.bytes.data() + plane.offset;
      for (uint32_t row = 0; row < tensor_.rows / planes; ++row, to += tensor_.row_bytes)
        std::memcpy(to, from + static_cast<ptrdiff_t>(row) * plane.stride, tensor_.row_bytes);
    }
  }
  gst_buffer_copy_into(out->get(), buffer, GST_BUFFER_COPY_METADATA, 0, static_cast<gsize>(-1));
  ledger->copied(frame_bytes() + picture.bytes_copied());
  return out;
}

}  // namespace weir
