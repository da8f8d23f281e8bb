// FrameArguments: a buffer's tensors as functions of the C ABI take them.
#pragma once
#include <gst/gst.h>

#include <vector>

#include "gstcpp/frame_reader.hpp"
#include "gstcpp/tensor_meta.hpp"
#include "weir/abi.h"

namespace weir::gst {

// Shapes outermost-first, no batch axis.
weir_tensor_info tensor_info(const TensorSpec& spec);

class FrameArguments {
 public:
  // The frame borrows what `reader` mapped and the times of `buffer`; valid until the next call,
  // and while both live.
  const weir_frame& fill(const FrameReader& reader, GstBuffer* buffer);

 private:
  std::vector<weir_tensor> tensors_;
  FrameMaps maps_;
  weir_frame frame_{};
};

}  // namespace weir::gst
