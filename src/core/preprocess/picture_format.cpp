// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/preprocess/picture_format.hpp"

#include <string>

#include "weir/join.hpp"

namespace weir::preprocess {
namespace {

constexpr PictureFormat packed(std::string_view name, uint8_t step, uint8_t r, uint8_t g,
                               uint8_t b) {
  return {name, ColorModel::Rgb, {Component{0, r, step}, {0, g, step}, {0, b, step}}};
}

// Y'CbCr with one chroma sample for each 2 x 2 pixels.
constexpr PictureFormat halved(std::string_view name, Component blue, Component red) {
  blue.halved_columns = blue.halved_rows = red.halved_columns = red.halved_rows = true;
  return {name, ColorModel::Yuv, {Component{}, blue, red}};
}

// Y'CbCr in one plane, two pixels in four bytes.
constexpr PictureFormat pairs(std::string_view name, uint8_t y, uint8_t cb, uint8_t cr) {
  return {name, ColorModel::Yuv, {Component{0, y, 2}, {0, cb, 4, true}, {0, cr, 4, true}}};
}

constexpr std::array kFormats{packed("RGB", 3, 0, 1, 2),
                              packed("BGR", 3, 2, 1, 0),
                              packed("RGBx", 4, 0, 1, 2),
                              packed("BGRx", 4, 2, 1, 0),
                              packed("xRGB", 4, 1, 2, 3),
                              packed("xBGR", 4, 3, 2, 1),
                              packed("RGBA", 4, 0, 1, 2),
                              packed("BGRA", 4, 2, 1, 0),
                              packed("ARGB", 4, 1, 2, 3),
                              packed("ABGR", 4, 3, 2, 1),
                              PictureFormat{"GRAY8", ColorModel::Gray, {}},
                              halved("NV12", {1, 0, 2}, {1, 1, 2}),
                              halved("NV21", {1, 1, 2}, {1, 0, 2}),
                              halved("I420", {1, 0, 1}, {2, 0, 1}),
                              halved("YV12", {2, 0, 1}, {1, 0, 1}),
                              pairs("YUY2", 0, 1, 3),
                              pairs("UYVY", 1, 0, 2)};

}  // namespace

std::span<const PictureFormat> picture_formats() noexcept {
  return kFormats;
}

Result<PictureFormat> picture_format(std::string_view name) {
  for (const auto& format : kFormats)
    if (format.name == name) return format;
  return Error{.code = Code::FORMAT_UNSUPPORTED,
               .what = "pictures of this format cannot be preprocessed",
               .offered = std::string(name),
               .needed = join(kFormats, ", ", [](const auto& format) { return format.name; }),
               .fix = "videoconvert ! tensor_preprocess"};
}

}  // namespace weir::preprocess
