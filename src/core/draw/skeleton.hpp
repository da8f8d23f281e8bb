// Draws the key points of a body: lines between them with dots at their ends, and their names.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "core/draw/rgba_frame.hpp"

namespace weir::draw {

// A key point in pixels of the frame; nullopt if it was not found.
struct PixelPoint {
  int64_t x = 0, y = 0;
  bool operator==(const PixelPoint&) const = default;
};
using Joint = std::optional<PixelPoint>;

// Two joints, by their index, that a line connects. Both may be the same.
struct Bone {
  size_t from = 0, to = 0;
  bool operator==(const Bone&) const = default;
};

// A dot: the pixels at most 4 steps along rows and columns away, without the centre.
void draw_dot(RgbaFrame& frame, PixelPoint at, Rgba color) noexcept;
// Draws each bone whose joints were found. Precondition: each bone's indices are less than the
// number of joints.
void draw_skeleton(RgbaFrame& frame, std::span<const Joint> joints, std::span<const Bone> bones,
                   Rgba color) noexcept;
// Writes the name of each joint that was found, above it where there is room. Names are as many as
// joints.
void draw_names(RgbaFrame& frame, std::span<const Joint> joints, std::span<const std::string> names,
                Rgba color) noexcept;

using Connection = std::pair<uint8_t, uint8_t>;

// 17: COCO's key points, in its order (cocodataset.org, person key points). 33: MediaPipe's pose
// landmarks. 21: its hand landmarks. Empty for other numbers.
std::span<const Connection> get_connections(size_t points) noexcept;

}  // namespace weir::draw
