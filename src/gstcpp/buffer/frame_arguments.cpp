// Converts the mapped tensors of a buffer to weir_tensor.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "gstcpp/buffer/frame_arguments.hpp"

namespace weir::gst {

weir_tensor_info tensor_info(const TensorSpec& spec) {
  weir_tensor_info info{};
  info.type = static_cast<uint32_t>(spec.type);
  info.rank = static_cast<uint32_t>(spec.shape.rank());
  for (uint32_t i = 0; i < info.rank; ++i) info.shape[i] = spec.shape[info.rank - 1 - i];
  info.batch_axis = WEIR_NO_BATCH_AXIS;
  return info;
}

const weir_frame& FrameArguments::fill(const FrameLayout& reader, GstBuffer* buffer,
                                       bool with_headers) {
  const auto& views = reader.tensors();
  tensors_.assign(views.size(), weir_tensor{});
  for (size_t i = 0; i < views.size(); ++i) {
    const size_t header = with_headers ? views[i].header_bytes : 0;  // directly before the payload
    tensors_[i].data = views[i].payload.data() - header;
    tensors_[i].bytes = views[i].payload.size() + header;
    tensors_[i].capacity = views[i].capacity + header;
    tensors_[i].flags = WEIR_TENSOR_READONLY;
    tensors_[i].fence_fd = -1;
    tensors_[i].info = tensor_info(views[i].spec);
  }
  frame_ = {};
  frame_.struct_size = sizeof frame_;
  frame_.n_tensors = static_cast<uint32_t>(tensors_.size());
  frame_.tensors = tensors_.data();
  const auto time = [](GstClockTime t) {
    return GST_CLOCK_TIME_IS_VALID(t) ? static_cast<int64_t>(t) : -1;
  };
  frame_.pts = time(GST_BUFFER_PTS(buffer));
  frame_.duration = time(GST_BUFFER_DURATION(buffer));
  frame_.deadline = -1;
  maps_.fill(buffer, {}, &frame_);
  return frame_;
}

}  // namespace weir::gst
