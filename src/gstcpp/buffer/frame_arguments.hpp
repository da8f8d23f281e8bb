// FrameArguments: a buffer's tensors as the functions of the C ABI take them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gst/gst.h>

#include <vector>

#include "gstcpp/buffer/frame_layout.hpp"
#include "gstcpp/buffer/tensor_meta.hpp"
#include "weir/abi.h"

namespace weir::gst {

// Shapes are outermost-first, without a batch axis.
weir_tensor_info tensor_info(const TensorSpec& spec);

class FrameArguments {
 public:
  // Borrows what `reader` mapped and the times of `buffer`; valid until the next call and while
  // both exist. `with_headers`: the bytes of flexible tensors include their headers.
  const weir_frame& fill(const FrameLayout& reader, GstBuffer* buffer, bool with_headers = false);

 private:
  std::vector<weir_tensor> tensors_;
  FrameMaps maps_;
  weir_frame frame_{};
};

}  // namespace weir::gst
