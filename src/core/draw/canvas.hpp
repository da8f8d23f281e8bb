// Canvas: draws into the memory of a picture in the picture's own format.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/draw/color.hpp"
#include "core/draw/mask.hpp"
#include "weir/result.hpp"

namespace weir::draw {

// Row r of a plane begins at byte offset + r * stride of `memory`, which is borrowed.
struct Plane {
  std::span<std::byte> memory;
  size_t offset = 0;
  ptrdiff_t stride = 0;  // may be negative
};
using Planes = std::array<Plane, 3>;  // only the format's planes are used

// Pixels left to right - 1 and top to bottom - 1; may exceed the picture.
struct Area {
  int64_t left = 0, top = 0, right = 0, bottom = 0;
  bool empty() const noexcept { return left >= right || top >= bottom; }
  bool operator==(const Area&) const = default;
};
Area common_part(const Area& a, const Area& b) noexcept;

// A chroma sample of 4:2:0 or 4:2:2 gets the colour if any of its pixels does.
class Canvas {
 public:
  // FRAME_SIZE if a plane is shorter than the picture.
  static Result<Canvas> make(const preprocess::Picture& picture, const Planes& planes);

  const preprocess::Picture& picture() const noexcept { return picture_; }
  Area all() const noexcept;
  // Whether pixels share chroma; masks must then begin at an even column and row.
  bool halved() const noexcept { return halved_; }
  void fill(const Area& area, const Paint& paint) noexcept;
  // Mixes `opacity` / 255 of the colour into the pixels. Shared chroma is mixed where its pixel of
  // an even row and column is; two pixels of a packed 4:2:2 format are mixed together.
  void tint(const Area& area, uint8_t opacity, const Paint& paint) noexcept;
  // Blends the colour by the mask's coverage. x and y are at least 0.
  void blend(int64_t x, int64_t y, const PlaneMask& mask, const Paint& paint) noexcept;

 private:
  Canvas(const preprocess::Picture& picture, const Planes& planes);
  std::byte* at(size_t plane, int64_t x, int64_t y) const noexcept;  // in units of the plane
  void fill_plane(size_t plane, const Area& part, const Paint& paint) noexcept;
  void fill_component(const preprocess::Component& component, const Area& part,
                      uint8_t sample) noexcept;

  preprocess::Picture picture_;
  Planes planes_;
  // The coarsest component of each plane: its step is the plane's unit.
  std::array<preprocess::Component, 3> components_;
  // Whether a plane has components of different steps (YUY2).
  std::array<bool, 3> mixed_{};
  bool halved_ = false;
};

}  // namespace weir::draw
