// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/draw/color.hpp"

#include <algorithm>
#include <cmath>

namespace weir::draw {
namespace {

using preprocess::ColorMatrix;
using preprocess::ColorModel;
using preprocess::ColorRange;

uint8_t to_byte(double value) {
  return static_cast<uint8_t>(std::clamp(std::floor(value + 0.5), 0.0, 255.0));
}

double luma(const Rgb& c, double red, double blue) {
  return (red * c.red + (1 - red - blue) * c.green + blue * c.blue) / 255;
}

uint8_t luma_sample(double luma, ColorRange range) {
  return to_byte(range == ColorRange::Full ? 255 * luma : 16 + 219 * luma);
}

// The weights of red and blue in luma.
std::pair<double, double> weights(ColorMatrix matrix) {
  switch (matrix) {
    case ColorMatrix::Bt709:
      return {0.2126, 0.0722};
    case ColorMatrix::Bt2020:
      return {0.2627, 0.0593};
    default:
      return {0.299, 0.114};
  }
}

}  // namespace

Rgb class_color(uint64_t class_index) noexcept {
  constexpr double kGolden = 0.6180339887498949, kFirst = 1.0 / 3;  // the first class is green
  const double hue = kFirst + kGolden * static_cast<double>(class_index % 100000);
  const auto part = [hue](double shift) {
    const double place = (hue + shift - std::floor(hue + shift)) * 6;
    return to_byte(255 * (0.15 + 0.85 * std::clamp(std::abs(place - 3) - 1, 0.0, 1.0)));
  };
  return {part(0), part(2.0 / 3), part(1.0 / 3)};
}

Rgb depth_color(uint32_t level) noexcept {
  // Five colours of the map "viridis", with straight lines between them.
  constexpr double kStops[][3] = {
      {68, 1, 84}, {59, 82, 139}, {33, 145, 140}, {94, 201, 98}, {253, 231, 37}};
  constexpr double kParts = std::size(kStops) - 1;
  const double at = std::min(level, 255u) / 255.0 * kParts;
  const auto stop = std::min(static_cast<size_t>(at), std::size(kStops) - 2);
  const auto part = [&](size_t i) {
    const double from = kStops[stop][i], to = kStops[stop + 1][i];
    return to_byte(from + (to - from) * (at - static_cast<double>(stop)));
  };
  return {part(0), part(1), part(2)};
}

Rgb text_color(Rgb ground) noexcept {
  return luma(ground, 0.299, 0.114) > 0.5 ? Rgb{0, 0, 0} : Rgb{255, 255, 255};
}

std::array<uint8_t, 3> to_samples(const preprocess::Picture& picture, Rgb c) noexcept {
  if (picture.format.model == ColorModel::Rgb) return {c.red, c.green, c.blue};
  if (picture.format.model == ColorModel::Gray)
    return {luma_sample(luma(c, 0.299, 0.114), picture.range), 0, 0};
  const auto [red, blue] = weights(picture.matrix);
  const double y = luma(c, red, blue);
  const double scale = picture.range == ColorRange::Full ? 255 : 224;
  return {luma_sample(y, picture.range),
          to_byte(128 + scale * (c.blue / 255. - y) / (2 - 2 * blue)),
          to_byte(128 + scale * (c.red / 255. - y) / (2 - 2 * red))};
}

Paint make_paint(const preprocess::Picture& picture, Rgb color) noexcept {
  Paint out;
  for (Pattern& pattern : out.planes) pattern.fill(255);
  const auto samples = to_samples(picture, color);
  for (size_t i = 0; i < picture.format.component_count(); ++i) {
    const preprocess::Component& component = picture.format.components[i];
    for (size_t at = component.offset; at < kPatternBytes; at += component.step)
      out.planes[component.plane][at] = samples[i];
  }
  return out;
}

}  // namespace weir::draw
