// The tables of connections.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/draw/skeletons.hpp"

namespace weir::draw {
namespace {

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

std::span<const Connection> connections_of(size_t points) noexcept {
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
