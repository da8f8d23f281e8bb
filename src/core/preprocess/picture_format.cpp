// The table of picture formats.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/preprocess/picture_format.hpp"

#include <string>

#include "weir/join.hpp"

namespace weir::preprocess {
namespace {

constexpr PictureFormat packed(std::string_view name, uint8_t step, uint8_t r, uint8_t g,
                               uint8_t b) {
  return {
      name, ColorModel::Rgb, {Lane{0, r, step, false}, {0, g, step, false}, {0, b, step, false}}};
}

constexpr std::array kFormats{
    packed("RGB", 3, 0, 1, 2),
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
    PictureFormat{"NV12", ColorModel::Yuv, {Lane{}, {1, 0, 2, true}, {1, 1, 2, true}}},
    PictureFormat{"I420", ColorModel::Yuv, {Lane{}, {1, 0, 1, true}, {2, 0, 1, true}}}};

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
