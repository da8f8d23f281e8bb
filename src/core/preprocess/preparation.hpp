// Preparation: how a decoded picture becomes the tensor that a network takes.
//
// Coordinates: a picture of width w reaches from 0 to w; pixel i from i to i + 1. Of an axis, the
// source part [begin, begin + length) is laid on n target pixels; s = length / n. Target pixel t is
//   nearest   source pixel begin + floor(t * s)
//   bilinear  (1 - f) * p[i] + f * p[i + 1] with i + f = begin + (t + 0.5) * s - 0.5; pixels beyond
//             the part are its outermost ones
//   area      the mean of the source between begin + t * s and begin + (t + 1) * s, parts of pixels
//             weighed by their share; along an axis that is not shrunk: bilinear
// These are OpenCV's INTER_NEAREST and INTER_LINEAR, and INTER_AREA where both axes are shrunk.
//
// Chroma of 4:2:0 is taken at the same place: sample j reaches from 2j to 2j + 2, or from 2j - 0.5
// to 2j + 1.5 where it is co-sited with the even pixel. Nearest takes the sample of the pixel's
// pair. Y'CbCr is resized as it is and becomes R'G'B', limited to 0..255, at the target's size.
// Gray of R'G'B' is 0.299 R' + 0.587 G' + 0.114 B'.
//
// number = (pixel - mean) * scale per channel, pixel being 0..255 and not rounded to whole steps:
// where no pixel is the mean of more than two rows and columns, each sample is off by 1/64 of a
// step at most (a colour of Y'CbCr by 1/16), and by nothing where it is not resized; quantised =
// round(number / quantisation.scale) + zero_point; integer types round to the nearest and saturate.
#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "core/preprocess/picture_format.hpp"
#include "core/tensor/frame_spec.hpp"
#include "weir/result.hpp"

namespace weir::preprocess {

enum class ColorMatrix : uint8_t { Bt601, Bt709, Bt2020 };
enum class Range : uint8_t { Limited, Full };  // luma 16..235 and chroma 16..240, or 0..255

enum class Resize : int32_t { Nearest, Bilinear, Area };
enum class Fit : int32_t {
  Stretch,    // the picture fills the target
  Letterbox,  // the whole picture in its proportions, in the middle of padding
  CentreCrop  // the middle part of the picture that has the target's proportions
};
enum class ChannelOrder : int32_t { Rgb, Bgr, Gray };
enum class Layout : int32_t { Nhwc, Nchw };

struct Picture {
  PictureFormat format;
  uint32_t width = 0, height = 0;
  ColorMatrix matrix = ColorMatrix::Bt601;  // of Y'CbCr
  Range range = Range::Full;                // of Y'CbCr and gray
  bool cosited_columns = false, cosited_rows = false;
};

struct Rect {
  uint32_t x = 0, y = 0, width = 0, height = 0;
  bool operator==(const Rect&) const = default;
};

// In pixels of the source picture; may reach beyond it.
struct Box {
  int64_t x = 0, y = 0, width = 0, height = 0;
  bool operator==(const Box&) const = default;
};

struct Quantisation {
  double scale = 1;
  int32_t zero_point = 0;
};

struct Preparation {
  Picture source;
  std::optional<Rect> crop;  // the part of the picture that counts; none = all of it
  // What is resized instead of that part; it may reach beyond it, and what is outside is padding.
  // Target pixels whose middle lies within the part are made of its pixels alone.
  std::optional<Box> region;
  uint32_t width = 0, height = 0;
  Resize resize = Resize::Bilinear;
  Fit fit = Fit::Stretch;
  double padding = 0;  // pixel value of each channel, 0..255
  ChannelOrder order = ChannelOrder::Rgb;
  std::vector<double> mean;                  // empty = 0; one, or one for each channel of `order`
  std::vector<double> scale;                 // empty = 1; likewise
  std::optional<Quantisation> quantisation;  // integer types only
  ElementType type = ElementType::UInt8;     // uint8, int8, float16 or float32
  Layout layout = Layout::Nhwc;

  size_t channels() const noexcept { return order == ChannelOrder::Gray ? 1 : 3; }
  // C:W:H:1 or W:H:C:1, innermost first.
  TensorSpec tensor() const noexcept;
};

inline constexpr uint32_t kSideLimit = 1u << 16;  // pixels, of pictures and of tensors

// All but the source. OPTION_VALUE says which part cannot be used.
Status check_target(const Preparation& preparation);
// OPTION_VALUE when the crop is empty or not within the picture.
Status check_crop(const Picture& source, const Rect& crop);
// All of it. FORMAT_UNSUPPORTED or LIMIT_EXCEEDED for the source, OPTION_VALUE for the crop.
Status check(const Preparation& preparation);

}  // namespace weir::preprocess
