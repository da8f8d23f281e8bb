// Test helpers: pictures in memory, and a plain way to set one pixel.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/draw/canvas.hpp"

namespace weir::draw {

inline const std::vector<std::string>& every_format() {
  static const std::vector<std::string> all{"RGB",  "BGR",  "RGBx", "BGRx", "xRGB",  "xBGR",
                                            "RGBA", "BGRA", "ARGB", "ABGR", "GRAY8", "NV12",
                                            "NV21", "I420", "YV12", "YUY2", "UYVY"};
  return all;
}

// Rows are longer than their pixels, and planes begin a few bytes into their memory; all bytes are
// 7.
struct TestPicture {
  preprocess::Picture picture;
  std::array<std::vector<std::byte>, 3> memory;
  Planes planes;

  TestPicture(const std::string& format, uint32_t width, uint32_t height, bool bottom_up = false) {
    picture.format = *preprocess::picture_format(format);
    picture.width = width;
    picture.height = height;
    picture.range = preprocess::ColorRange::Limited;
    for (const preprocess::Component& component : components()) {
      const size_t rows = component.halved_rows ? (height + 1) / 2 : height;
      const size_t stride =
          (component.halved_columns ? (width + 1) / 2 : width) * component.step + 5;
      memory[component.plane].assign(3 + rows * stride, std::byte{7});
      planes[component.plane] = {memory[component.plane], 3, static_cast<ptrdiff_t>(stride)};
      if (!bottom_up) continue;
      planes[component.plane].offset += (rows - 1) * stride;
      planes[component.plane].stride = -static_cast<ptrdiff_t>(stride);
    }
  }
  TestPicture(const TestPicture&) = delete;  // planes point into memory
  TestPicture& operator=(const TestPicture&) = delete;
  std::span<const preprocess::Component> components() const {
    return std::span(picture.format.components).first(picture.format.component_count());
  }
  Canvas canvas() const { return *Canvas::make(picture, planes); }
  uint8_t* sample(size_t component_index, int64_t x, int64_t y) {
    const preprocess::Component& component = picture.format.components[component_index];
    if (component.halved_columns) x /= 2;
    if (component.halved_rows) y /= 2;
    const Plane& plane = planes[component.plane];
    return reinterpret_cast<uint8_t*>(plane.memory.data() + plane.offset + y * plane.stride +
                                      x * component.step + component.offset);
  }
  // Sets one pixel and the chroma that it shares.
  void set(int64_t x, int64_t y, Rgb color) {
    if (x < 0 || y < 0 || x >= picture.width || y >= picture.height) return;
    const auto samples = to_samples(picture, color);
    const preprocess::Component& first = picture.format.components[0];
    if (first.step == 4)
      for (size_t i = 0; i < 4; ++i)
        sample(0, x, y)[static_cast<ptrdiff_t>(i) - first.offset] = 255;
    for (size_t i = 0; i < picture.format.component_count(); ++i) *sample(i, x, y) = samples[i];
  }
  bool operator==(const TestPicture& other) const { return memory == other.memory; }
};

}  // namespace weir::draw
