// Dots, bones and names of key points.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/draw/skeleton.hpp"

#include <algorithm>
#include <cstdlib>
#include <utility>

namespace weir::draw {
namespace {

constexpr int64_t kDotRadius = 4;
constexpr int64_t kNameAbove = 14;  // rows from the top of a name to its joint
constexpr int kThickness = 2;

}  // namespace

void draw_dot(RgbaFrame& frame, PixelPoint at, Rgba color) noexcept {
  for (int64_t dy = -kDotRadius; dy <= kDotRadius; ++dy) {
    const int64_t reach = kDotRadius - std::abs(dy);
    for (int64_t dx = -reach; dx <= reach; ++dx)
      if (dx != 0 || dy != 0) frame.set(at.x + dx, at.y + dy, color);
  }
}

void draw_skeleton(RgbaFrame& frame, std::span<const Joint> joints, std::span<const Bone> bones,
                   Rgba color) noexcept {
  for (const Bone& bone : bones) {
    Joint from = joints[bone.from], to = joints[bone.to];
    if (!from || !to) continue;
    draw_dot(frame, *from, color);
    draw_dot(frame, *to, color);
    if (from->x > to->x) std::swap(from, to);
    frame.line(from->x, from->y, to->x, to->y, color, kThickness);
  }
}

void draw_names(RgbaFrame& frame, std::span<const Joint> joints, std::span<const std::string> names,
                Rgba color) noexcept {
  for (size_t i = 0; i < joints.size(); ++i)
    if (const Joint& joint = joints[i])
      frame.text(joint->x, std::max<int64_t>(0, joint->y - kNameAbove), names[i], color);
}

}  // namespace weir::draw
