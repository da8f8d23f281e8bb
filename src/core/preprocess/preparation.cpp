// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/preprocess/preparation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace weir::preprocess {
namespace {

Error bad_option(const char* what, std::string offered, std::string needed, const char* fix = "") {
  return Error{.code = Code::OPTION_VALUE,
               .what = what,
               .offered = std::move(offered),
               .needed = std::move(needed),
               .fix = fix};
}

std::string size_text(uint64_t width, uint64_t height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

Status check_numbers(const char* name, const std::vector<double>& numbers, size_t channels) {
  if (numbers.size() > 1 && numbers.size() != channels)
    return bad_option("the number of values does not match the number of channels",
                      std::string(name) + " of " + std::to_string(numbers.size()) + " numbers",
                      "one number, or " + std::to_string(channels));
  for (const double number : numbers)
    if (!(std::fabs(number) <= double{std::numeric_limits<float>::max()}))
      return bad_option("a number is beyond the range of float32",
                        std::string(name) + " " + std::to_string(number), "a finite number");
  return ok();
}

Status check_quantisation(const Preparation& p) {
  if (!p.quantisation) return ok();
  const auto [scale, zero_point] = *p.quantisation;
  if (p.type != ElementType::UInt8 && p.type != ElementType::Int8)
    return bad_option("only integer types can be quantised", std::string(to_string(p.type)),
                      "uint8 or int8", "type=uint8, or no quantisation");
  if (!(scale >= double{std::numeric_limits<float>::min()} &&
        scale <= double{std::numeric_limits<float>::max()}))
    return bad_option("the scale of the quantisation cannot be used", std::to_string(scale),
                      "a number above 0");
  const int32_t low = p.type == ElementType::UInt8 ? 0 : -128;
  if (zero_point < low || zero_point > low + 255)
    return bad_option("the zero point is out of the range of the element type",
                      std::to_string(zero_point) + " of " + std::string(to_string(p.type)),
                      std::to_string(low) + " to " + std::to_string(low + 255));
  return ok();
}

}  // namespace

TensorSpec Preparation::tensor() const noexcept {
  const auto c = static_cast<uint32_t>(channels());
  const Shape shape =
      layout == Layout::Nhwc ? Shape{c, width, height, 1} : Shape{width, height, c, 1};
  return {type, shape, ""};
}

Status check_target(const Preparation& p) {
  if (p.width == 0 || p.height == 0)
    return bad_option("the size of the tensor is unknown", size_text(p.width, p.height),
                      "width and height, a card, or a downstream model that declares its input",
                      "tensor_preprocess width=224 height=224");
  if (p.width > kSideLimit || p.height > kSideLimit)
    return bad_option("the tensor is too large", size_text(p.width, p.height),
                      "at most " + size_text(kSideLimit, kSideLimit));
  if (p.type != ElementType::UInt8 && p.type != ElementType::Int8 &&
      p.type != ElementType::Float16 && p.type != ElementType::Float32)
    return bad_option("tensor_preprocess does not write this element type",
                      std::string(to_string(p.type)), "uint8, int8, float16 or float32");
  if (!(p.padding >= 0 && p.padding <= 255))
    return bad_option("the padding is not a pixel value", std::to_string(p.padding), "0 to 255");
  if (auto status = check_numbers("mean", p.mean, p.channels()); !status) return status;
  if (auto status = check_numbers("scale", p.scale, p.channels()); !status) return status;
  return check_quantisation(p);
}

Status check_crop(const Picture& source, const Rect& c) {
  const uint32_t width = source.width, height = source.height;
  const bool inside = c.width > 0 && c.height > 0 && c.width <= width && c.height <= height &&
                      c.x <= width - c.width && c.y <= height - c.height;
  if (inside) return ok();
  return bad_option(
      "the crop exceeds the picture",
      size_text(c.width, c.height) + " at " + std::to_string(c.x) + "," + std::to_string(c.y),
      "a part of " + size_text(width, height));
}

Status check(const Preparation& p) {
  if (auto status = check_target(p); !status) return status;
  if (auto format = picture_format(p.source.format.name); !format) return format.error();
  const uint32_t width = p.source.width, height = p.source.height;
  if (width == 0 || height == 0 || width > kSideLimit || height > kSideLimit)
    return Error{.code = Code::LIMIT_EXCEEDED,
                 .what = "the picture is empty or too large",
                 .offered = size_text(width, height),
                 .needed = "1x1 to " + size_text(kSideLimit, kSideLimit)};
  return p.crop ? check_crop(p.source, *p.crop) : ok();
}

}  // namespace weir::preprocess
