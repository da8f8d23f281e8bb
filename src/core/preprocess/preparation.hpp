// Preparation: how a decoded picture becomes the tensor that a network takes.
//
// Coordinates: a picture of width w extends from 0 to w, pixel i from i to i + 1. Along one axis,
// the source part [begin, begin + length) is mapped onto n target pixels; s = length / n. Target
// pixel t:
//   nearest   source pixel begin + floor(t * s)
//   bilinear  (1 - f) * p[i] + f * p[i + 1] with i + f = begin + (t + 0.5) * s - 0.5; pixels beyond
//             the part repeat its outermost ones
//   area      the mean of the source between begin + t * s and begin + (t + 1) * s, where partly
//             covered pixels count in proportion; along an axis that does not shrink: bilinear
// They equal OpenCV's INTER_NEAREST and INTER_LINEAR, and INTER_AREA if both axes shrink.
//
// Chroma of 4:2:0 is sampled at the same coordinates: sample j extends from 2j to 2j + 2, or, if it
// is co-sited with the even pixel, from 2j - 0.5 to 2j + 1.5. Nearest uses the sample of the
// pixel's pair. Y'CbCr is resized first and then converted to R'G'B', clamped to 0..255, at the
// target's size. Gray of R'G'B' is 0.299 R' + 0.587 G' + 0.114 B'.
//
// number = (pixel - mean) * scale per channel; pixel is 0..255 and not rounded to whole steps: it
// is off by at most 1/256 of a step; without resizing and Y'CbCr it is exact. quantised =
// round(number / quantisation.scale) + zero_point. Integer types round to the nearest value and
// saturate.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "core/preprocess/picture_format.hpp"
#include "core/tensor/frame_spec.hpp"
#include "core/tensor/geometry.hpp"
#include "weir/result.hpp"

namespace weir::preprocess {

enum class ColorMatrix : uint8_t { Bt601, Bt709, Bt2020 };
enum class ColorRange : uint8_t { Limited, Full };  // luma 16..235 and chroma 16..240, or 0..255

enum class Resize : int32_t { Nearest, Bilinear, Area };
enum class Fit : int32_t {
  Stretch,    // the picture fills the target
  Letterbox,  // the whole picture, centred, with its proportions; padding around it
  CentreCrop  // the largest centred part of the picture with the target's proportions
};
enum class ChannelOrder : int32_t { Rgb, Bgr, Gray };
enum class Layout : int32_t { Nhwc, Nchw };

struct Picture {
  PictureFormat format;
  uint32_t width = 0, height = 0;
  ColorMatrix matrix = ColorMatrix::Bt601;  // of Y'CbCr
  ColorRange range = ColorRange::Full;      // of Y'CbCr and gray
  bool cosited_columns = false, cosited_rows = false;
};

// In pixels of the source picture; may exceed it.
struct Roi {
  int64_t x = 0, y = 0, width = 0, height = 0;
  uint64_t row = 0;     // of the results that it comes from, plus 1; 0 = not known
  double rotation = 0;  // clockwise about its centre, in radians
  bool operator==(const Roi&) const = default;
};

struct Quantisation {
  double scale = 1;
  int32_t zero_point = 0;
};

struct Preparation {
  Picture source;
  std::optional<Rect> crop;  // the part of the picture that is used; none = all of it
  // Resized instead of `crop`; it may exceed that part, and everything outside it becomes padding.
  // Target pixels with their centre within the part use only pixels of the part.
  std::optional<Roi> region;
  uint32_t width = 0, height = 0;
  Resize resize = Resize::Bilinear;
  Fit fit = Fit::Stretch;
  double padding = 0;  // pixel value of each channel, 0..255
  ChannelOrder order = ChannelOrder::Rgb;
  std::vector<double> mean;   // empty = 0; one number, or one for each channel of `order`
  std::vector<double> scale;  // empty = 1; otherwise as `mean`
  std::optional<Quantisation> quantisation;  // integer types only
  ElementType type = ElementType::UInt8;     // uint8, int8, float16 or float32
  Layout layout = Layout::Nhwc;

  size_t channels() const noexcept { return order == ChannelOrder::Gray ? 1 : 3; }
  // C:W:H:1 or W:H:C:1, innermost first.
  TensorSpec tensor() const noexcept;
};

inline constexpr uint32_t kSideLimit = 1u << 16;  // pixels, for pictures and tensors

// Checks everything but the source. OPTION_VALUE; the text names the unusable part.
Status check_target(const Preparation& preparation);
// OPTION_VALUE if the crop is empty or not within the picture.
Status check_crop(const Picture& source, const Rect& crop);
// Checks everything. FORMAT_UNSUPPORTED or LIMIT_EXCEEDED for the source, OPTION_VALUE for the
// crop.
Status check(const Preparation& preparation);

}  // namespace weir::preprocess
