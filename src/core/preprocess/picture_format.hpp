// PictureFormat: where the samples of a pixel are in the memory of a decoded picture.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "weir/result.hpp"

namespace weir::preprocess {

enum class ColorModel : uint8_t { Gray, Rgb, Yuv };

// One kind of sample: byte `offset` of every `step` bytes in a row of `plane`.
struct Component {
  uint8_t plane = 0, offset = 0, step = 1;
  // One sample for two columns (4:2:2 and 4:2:0 chroma), for two rows (4:2:0).
  bool halved_columns = false, halved_rows = false;

  // Whether the samples of both are placed alike.
  bool same_grid(const Component& other) const noexcept {
    return step == other.step && halved_columns == other.halved_columns &&
           halved_rows == other.halved_rows;
  }
};

struct PictureFormat {
  std::string_view name;  // GStreamer's name
  ColorModel model = ColorModel::Gray;
  std::array<Component, 3> components;  // Gray: only the first; R, G, B; Y, Cb, Cr

  size_t component_count() const noexcept { return model == ColorModel::Gray ? 1 : 3; }
  size_t plane_count() const noexcept {
    size_t last = 0;
    for (size_t i = 0; i < component_count(); ++i)
      last = std::max<size_t>(last, components[i].plane);
    return last + 1;
  }
};

// RGB, BGR, RGBx, BGRx, xRGB, xBGR, RGBA, BGRA, ARGB, ABGR, GRAY8, NV12, NV21, I420, YV12, YUY2,
// UYVY. Alpha is not read.
std::span<const PictureFormat> picture_formats() noexcept;
// FORMAT_UNSUPPORTED if the format is unknown; the error lists the known formats.
Result<PictureFormat> picture_format(std::string_view name);

}  // namespace weir::preprocess
