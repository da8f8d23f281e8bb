// Draws key points, and lists which of them are connected.
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

// 0 nose, 1-2 eyes, 3-4 ears, 5-6 shoulders, 7-8 elbows, 9-10 wrists, 11-12 hips, 13-14 knees,
// 15-16 ankles.
constexpr Connection kCoco[] = {{0, 1},   {0, 2},   {1, 3},   {2, 4},  {5, 6},  {5, 7},
                                {7, 9},   {6, 8},   {8, 10},  {5, 11}, {6, 12}, {11, 12},
                                {11, 13}, {13, 15}, {12, 14}, {14, 16}};
// 0 nose, 1-6 eyes, 7-8 ears, 9-10 mouth, 11-12 shoulders, 13-14 elbows, 15-16 wrists, 17-22
// fingers, 23-24 hips, 25-26 knees, 27-28 ankles, 29-30 heels, 31-32 toes.
constexpr Connection kPose[] = {
    {0, 1},   {1, 2},   {2, 3},   {3, 7},   {0, 4},   {4, 5},   {5, 6},   {6, 8},   {9, 10},
    {11, 12}, {11, 13}, {13, 15}, {15, 17}, {15, 19}, {15, 21}, {17, 19}, {12, 14}, {14, 16},
    {16, 18}, {16, 20}, {16, 22}, {18, 20}, {11, 23}, {12, 24}, {23, 24}, {23, 25}, {25, 27},
    {27, 29}, {27, 31}, {29, 31}, {24, 26}, {26, 28}, {28, 30}, {28, 32}, {30, 32}};
// 0 wrist, then four joints of each finger from the thumb on.
constexpr Connection kHand[] = {{0, 1},   {1, 2},   {2, 3},   {3, 4},   {0, 5},   {5, 6},
                                {6, 7},   {7, 8},   {5, 9},   {9, 10},  {10, 11}, {11, 12},
                                {9, 13},  {13, 14}, {14, 15}, {15, 16}, {13, 17}, {17, 18},
                                {18, 19}, {19, 20}, {0, 17}};

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

std::span<const Connection> get_connections(size_t points) noexcept {
  switch (points) {
    case 17:
      return kCoco;
    case 21:
      return kHand;
    case 33:
      return kPose;
    default:
      return {};
  }
}

}  // namespace weir::draw
