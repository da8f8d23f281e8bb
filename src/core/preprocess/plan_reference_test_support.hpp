// Test helpers: pictures of random bytes, and the formulas of preparation.hpp in double precision,
// one number at a time.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <span>
#include <string_view>
#include <vector>

#include "core/preprocess/plan.hpp"

namespace weir::preprocess::testing {

// A picture whose planes share one memory block, with gaps before, between and after the rows.
struct Pixels {
  Picture picture;
  std::vector<std::byte> memory;
  Planes planes;

  Pixels(std::string_view format, uint32_t width, uint32_t height, uint32_t seed = 1,
         size_t gap = 0) {
    picture.format = *picture_format(format);
    picture.width = width;
    picture.height = height;
    std::array<size_t, 3> offsets{}, strides{};
    size_t end = gap;
    for (size_t i = 0; i < picture.format.plane_count(); ++i) {
      uint32_t rows = height;
      for (const Component& component : components()) {
        if (component.plane != i) continue;
        const uint32_t columns = component.halved_columns ? (width + 1) / 2 : width;
        strides[i] = std::max(strides[i], size_t{columns} * component.step + gap);
        if (component.halved_rows) rows = (height + 1) / 2;
      }
      offsets[i] = end;
      end += strides[i] * rows;
    }
    memory.resize(end - gap);
    std::mt19937 random(seed);
    for (auto& byte : memory) byte = static_cast<std::byte>(random());
    for (size_t i = 0; i < picture.format.plane_count(); ++i)
      planes[i] = {memory, offsets[i], static_cast<ptrdiff_t>(strides[i])};
  }

  std::span<const Component> components() const {
    return std::span(picture.format.components).first(picture.format.component_count());
  }
  double sample(size_t component, int64_t x, int64_t y) const {
    const Component& l = picture.format.components[component];
    const Plane& plane = planes[l.plane];
    const int64_t at = static_cast<int64_t>(plane.offset) + y * plane.stride + x * l.step;
    return std::to_integer<int>(plane.memory[static_cast<size_t>(at) + l.offset]);
  }
};

// The weight of sample `index` in target pixel t by preparation.hpp. Only samples of the pixels
// from_pixel to to_pixel count.
inline double share(Resize resize, const AxisWhole& whole, double from_pixel, double to_pixel,
                    double t, bool halved, bool cosited, int64_t index) {
  const auto begin = static_cast<double>(whole.begin);
  const double length = whole.length, targets = whole.targets;
  const double pixels = halved ? 2 : 1, step = length / targets;
  const double shift = halved && cosited ? 0.5 : 0;  // in pixels
  const int64_t low = static_cast<int64_t>(from_pixel / pixels);
  const int64_t high = static_cast<int64_t>(std::ceil(to_pixel / pixels));
  t += whole.first;
  if (index < low || index >= high) return 0;
  if (resize == Resize::Nearest) {
    const double pixel =
        std::clamp(begin + std::floor(t * length / targets), from_pixel, to_pixel - 1);
    return static_cast<double>(index) == std::floor(pixel / pixels) ? 1 : 0;
  }
  if (resize == Resize::Area && step > pixels) {
    const auto inside = [&](double edge) {
      return std::clamp((begin + edge * step + shift) / pixels, double(low), double(high));
    };
    const double from = inside(t), to = inside(t + 1);
    return std::max(0.0, std::min(to, index + 1.0) - std::max(from, double(index))) / (to - from);
  }
  const double position =
      std::clamp((begin + (t + 0.5) * step + shift) / pixels - 0.5, double(low), double(high - 1));
  return std::max(0.0, 1 - std::fabs(position - static_cast<double>(index)));
}

// The samples of one target pixel along an axis with their weights.
using Weights = std::vector<std::pair<uint32_t, double>>;

// Of each target pixel of the content along an axis, for one component.
struct ComponentWeights {
  std::vector<Weights> columns, rows;

  ComponentWeights(const Preparation& p, const Placement& place, size_t component) {
    const Component& c = p.source.format.components[component];
    const Rect &part = place.source, &content = place.content;
    columns = along(
        p.resize, place.columns.value_or(AxisWhole{part.x, part.width, content.width, 0}), part.x,
        part.width, content.width, c.halved_columns, p.source.cosited_columns, p.source.width);
    rows = along(p.resize, place.rows.value_or(AxisWhole{part.y, part.height, content.height, 0}),
                 part.y, part.height, content.height, c.halved_rows, p.source.cosited_rows,
                 p.source.height);
  }

  static std::vector<Weights> along(Resize resize, const AxisWhole& whole, uint32_t begin,
                                    uint32_t length, uint32_t targets, bool halved, bool cosited,
                                    uint32_t pixels) {
    std::vector<Weights> out(targets);
    for (uint32_t t = 0; t < targets; ++t)
      for (uint32_t i = 0; i < (halved ? (pixels + 1) / 2 : pixels); ++i) {
        const double weight = share(resize, whole, begin, begin + length, t, halved, cosited, i);
        if (weight > 0) out[t].emplace_back(i, weight);
      }
    return out;
  }
};

// The value of sample `component` at the target pixel (x, y) of the content.
inline double resized(const ComponentWeights& weights, const Pixels& pixels, size_t component,
                      uint32_t x, uint32_t y) {
  double sum = 0;
  for (const auto& [row, wy] : weights.rows[y])
    for (const auto& [column, wx] : weights.columns[x])
      sum += wy * wx * pixels.sample(component, column, row);
  return sum;
}

// R, G and B, or three times gray, 0..255.
inline std::array<double, 3> rgb(const Preparation& p, const std::array<double, 3>& s) {
  if (p.source.format.model == ColorModel::Rgb) return s;
  const bool full = p.source.range == ColorRange::Full;
  const double luma = full ? s[0] : (s[0] - 16) * 255 / 219;
  const auto limit = [](double v) { return std::clamp(v, 0.0, 255.0); };
  if (p.source.format.model == ColorModel::Gray) return {limit(luma), limit(luma), limit(luma)};
  const double chroma = full ? 255 : 224;
  const double cb = (s[1] - 128) / chroma, cr = (s[2] - 128) / chroma;  // -0.5..0.5
  const double kr = p.source.matrix == ColorMatrix::Bt601   ? 0.299
                    : p.source.matrix == ColorMatrix::Bt709 ? 0.2126
                                                            : 0.2627;
  const double kb = p.source.matrix == ColorMatrix::Bt601   ? 0.114
                    : p.source.matrix == ColorMatrix::Bt709 ? 0.0722
                                                            : 0.0593;
  const double y = luma / 255, red = y + cr * 2 * (1 - kr), blue = y + cb * 2 * (1 - kb);
  const double green = (y - kr * red - kb * blue) / (1 - kr - kb);
  return {limit(255 * red), limit(255 * green), limit(255 * blue)};
}

inline double pixel(const Preparation& p, const Placement& place,
                    const std::vector<ComponentWeights>& weights, const Pixels& pixels,
                    size_t channel, uint32_t x, uint32_t y) {
  const Rect& c = place.content;
  if (x < c.x || y < c.y || x >= c.x + c.width || y >= c.y + c.height) return p.padding;
  std::array<double, 3> s{};
  for (size_t component = 0; component < weights.size(); ++component)
    s[component] = resized(weights[component], pixels, component, x - c.x, y - c.y);
  if (p.order == ChannelOrder::Gray && p.source.format.model == ColorModel::Yuv) s[1] = s[2] = 128;
  const auto color = rgb(p, s);
  if (p.order == ChannelOrder::Gray)
    return p.source.format.model == ColorModel::Rgb
               ? 0.299 * color[0] + 0.587 * color[1] + 0.114 * color[2]
               : color[0];
  return color[p.order == ChannelOrder::Bgr ? 2 - channel : channel];
}

// The tensor's numbers in the order of its elements, before quantisation and rounding.
//
inline std::vector<double> reference(const Preparation& p, const Pixels& pixels) {
  const Placement place = preprocess::place(p);
  const size_t channels = p.channels();
  std::vector<ComponentWeights> weights;
  for (size_t component = 0; component < p.source.format.component_count(); ++component)
    weights.emplace_back(p, place, component);
  std::vector<double> out(channels * p.width * p.height);
  const auto of = [](const std::vector<double>& numbers, size_t c, double otherwise) {
    return numbers.empty() ? otherwise : numbers[numbers.size() == 1 ? 0 : c];
  };
  for (uint32_t y = 0; y < p.height; ++y)
    for (uint32_t x = 0; x < p.width; ++x)
      for (size_t c = 0; c < channels; ++c) {
        const size_t at = p.layout == Layout::Nhwc ? (size_t{y} * p.width + x) * channels + c
                                                   : (c * p.height + y) * p.width + x;
        out[at] =
            (pixel(p, place, weights, pixels, c, x, y) - of(p.mean, c, 0)) * of(p.scale, c, 1);
      }
  return out;
}

template <class T>
std::vector<T> run(const Preparation& preparation, const Pixels& pixels) {
  const auto plan = PreprocessPlan::make(preparation);
  if (!plan) return {};
  std::vector<T> out(preparation.channels() * preparation.width * preparation.height);
  auto workspace = plan->workspace();
  if (!plan->run(pixels.planes, std::as_writable_bytes(std::span(out)), &workspace)) return {};
  return out;
}

}  // namespace weir::preprocess::testing
