// PictureFormat: where the samples of a pixel lie in the memory of a decoded picture.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "weir/result.hpp"

namespace weir::preprocess {

enum class ColorModel : uint8_t { Gray, Rgb, Yuv };

// One kind of sample: byte `offset` of each `step` bytes in a row of `plane`.
struct Lane {
  uint8_t plane = 0, offset = 0, step = 1;
  bool halved = false;  // one sample for two columns and two rows (chroma of 4:2:0)
};

struct PictureFormat {
  std::string_view name;  // as GStreamer writes it
  ColorModel model = ColorModel::Gray;
  std::array<Lane, 3> lanes;  // Gray: 1 of them; R, G, B; Y, Cb, Cr

  size_t lane_count() const noexcept { return model == ColorModel::Gray ? 1 : 3; }
  size_t plane_count() const noexcept { return size_t{lanes[lane_count() - 1].plane} + 1; }
};

// RGB, BGR, RGBx, BGRx, xRGB, xBGR, RGBA, BGRA, ARGB, ABGR, GRAY8, NV12, I420. Alpha is not read.
std::span<const PictureFormat> picture_formats() noexcept;
// FORMAT_UNSUPPORTED, with the formats that are known.
Result<PictureFormat> picture_format(std::string_view name);

}  // namespace weir::preprocess
