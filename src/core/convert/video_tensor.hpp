// VideoTensor: the tensor of a raw video frame (docs/compatibility/converter.md 2.3).
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <string_view>

#include "core/tensor/frame_spec.hpp"

namespace weir {

struct VideoTensor {
  TensorSpec spec;         // C:W:H:N, planar formats W:H:3:N
  uint64_t row_bytes = 0;  // one row without padding (of one plane in planar formats)
  uint32_t rows = 0;       // the rows of all planes of one frame
};

// `format` is GStreamer's name. FORMAT_UNSUPPORTED, with a videoconvert line, for others.
Result<VideoTensor> video_tensor(std::string_view format, uint32_t width, uint32_t height,
                                 uint32_t frames_per_tensor);

}  // namespace weir
