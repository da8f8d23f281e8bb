// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/convert/video_tensor.hpp"

#include <algorithm>
#include <array>
#include <string>

namespace weir {
namespace {

struct Layout {
  std::string_view format;
  uint32_t channels;
  ElementType type;
  bool planar;
};
constexpr std::array kLayouts{Layout{"RGB", 3, ElementType::UInt8, false},
                              Layout{"BGR", 3, ElementType::UInt8, false},
                              Layout{"RGBx", 4, ElementType::UInt8, false},
                              Layout{"BGRx", 4, ElementType::UInt8, false},
                              Layout{"xRGB", 4, ElementType::UInt8, false},
                              Layout{"xBGR", 4, ElementType::UInt8, false},
                              Layout{"RGBA", 4, ElementType::UInt8, false},
                              Layout{"BGRA", 4, ElementType::UInt8, false},
                              Layout{"ARGB", 4, ElementType::UInt8, false},
                              Layout{"ABGR", 4, ElementType::UInt8, false},
                              Layout{"GRAY8", 1, ElementType::UInt8, false},
                              Layout{"GRAY16_BE", 1, ElementType::UInt16, false},
                              Layout{"GRAY16_LE", 1, ElementType::UInt16, false},
                              Layout{"RGBP", 3, ElementType::UInt8, true},
                              Layout{"BGRP", 3, ElementType::UInt8, true}};

}  // namespace

Result<VideoTensor> video_tensor(std::string_view format, uint32_t width, uint32_t height,
                                 uint32_t frames_per_tensor) {
  const auto layout = std::find_if(kLayouts.begin(), kLayouts.end(),
                                   [&](const auto& l) { return l.format == format; });
  if (layout == kLayouts.end())
    return Error{.code = Code::FORMAT_UNSUPPORTED,
                 .what = "this video format cannot be a tensor",
                 .offered = std::string(format),
                 .needed = "RGB, BGR, a format of four bytes, GRAY8, GRAY16, RGBP or BGRP",
                 .fix = "videoconvert ! video/x-raw,format=RGB ! tensor_converter"};
  VideoTensor out;
  out.spec.type = layout->type;
  out.spec.shape = layout->planar ? Shape{width, height, layout->channels, frames_per_tensor}
                                  : Shape{layout->channels, width, height, frames_per_tensor};
  out.row_bytes =
      uint64_t{width} * (layout->planar ? 1 : layout->channels) * element_size(layout->type);
  const uint64_t rows = layout->planar ? uint64_t{height} * layout->channels : height;
  out.rows = static_cast<uint32_t>(rows);
  if (frames_per_tensor == 0 || rows > UINT32_MAX || !out.spec.valid() || !out.spec.bytes())
    return Error{
        .code = Code::LIMIT_EXCEEDED,
        .what = "a video frame is too big or empty",
        .offered = out.spec.to_string(),
        .needed = "at least one pixel and one frame, and fewer than 2^32 rows in all planes"};
  return out;
}

}  // namespace weir
