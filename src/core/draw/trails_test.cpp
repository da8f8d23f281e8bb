// Tests of trails: what is kept of a track, and for how long.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/draw/trails.hpp"

#include <gtest/gtest.h>

#include "core/draw/draw_test_support.hpp"
#include "core/draw/overlay.hpp"

namespace weir::draw {
namespace trails_test {

Detection row(double x, double bottom, uint32_t track, uint32_t class_index = 0) {
  Detection out;
  out.x1 = x - 2, out.x2 = x + 2, out.y1 = bottom - 4, out.y2 = bottom;
  out.track = track, out.class_index = class_index;
  return out;
}
Detections rows(std::vector<Detection> all) {
  Detections out;
  out.rows = std::move(all);
  return out;
}
std::vector<double> columns(const Trails& trails, uint32_t track) {
  std::vector<double> out;
  for (const Point& p : trails.of(row(0, 0, track))) out.push_back(p.x);
  return out;
}
using Numbers = std::vector<double>;

TEST(Trails, KeepTheLastPositionsOfATrack) {
  Trails trails;
  trails.set_length(3);
  for (int i = 0; i < 5; ++i) trails.add(rows({row(i, 10, 7), row(10 * i, 20, 8)}));
  EXPECT_EQ(columns(trails, 7), (Numbers{2, 3, 4}));
  EXPECT_EQ(columns(trails, 8), (Numbers{20, 30, 40}));
  EXPECT_EQ(trails.of(row(0, 0, 8)).back().y, 20);
  EXPECT_EQ(columns(trails, 9), Numbers());
  trails.set_length(1);
  EXPECT_EQ(columns(trails, 7), Numbers{4});
}

TEST(Trails, OfLengthZeroAreNone) {
  Trails trails;
  trails.add(rows({row(1, 10, 7)}));
  EXPECT_EQ(trails.size(), 0u);
}

TEST(Trails, SkipObjectsWithoutATrackAndNumbersThatAreTwiceInAFrame) {
  Trails trails;
  trails.set_length(5);
  trails.add(rows({row(1, 10, 0), row(2, 10, 7), row(3, 10, 7)}));
  EXPECT_EQ(columns(trails, 7), Numbers{2});
  EXPECT_EQ(columns(trails, 0), Numbers());
  EXPECT_EQ(trails.size(), 1u);
}

TEST(Trails, ForgetTracksThatVanish) {
  Trails trails;
  trails.set_length(3);
  trails.add(rows({row(1, 10, 7)}));
  for (int i = 0; i < 2; ++i) trails.add(rows({}));
  trails.add(rows({row(5, 10, 7)}));
  EXPECT_EQ(columns(trails, 7), (Numbers{1, 5})) << "a short gap";
  for (int i = 0; i < 4; ++i) trails.add(rows({}));
  EXPECT_EQ(trails.size(), 0u);
}

TEST(Trails, AreBoundedWhileTracksChange) {
  Trails trails;
  trails.set_length(30);
  for (uint32_t i = 0; i < 20000; ++i) {
    trails.add(rows({row(1, 10, 1 + i), row(1, 10, 100000 + i)}));
    ASSERT_LE(trails.size(), 64u);
  }
  std::vector<Detection> crowd;
  for (uint32_t i = 1; i <= 3 * kTrailLimit; ++i) crowd.push_back(row(1, 10, i));
  trails.add(rows(crowd));
  EXPECT_EQ(trails.size(), kTrailLimit);
}

// The sample of a pixel of an RGB picture as a colour.
Rgb pixel(TestPicture& picture, int64_t x, int64_t y) {
  const uint8_t* at = picture.sample(0, x, y);
  return {at[0], at[1], at[2]};
}

TEST(Trails, AreDrawnInTheColourOfTheTrack) {
  Trails trails;
  trails.set_length(10);
  trails.add(rows({row(10, 20, 7, 3)}));
  const auto now = rows({row(50, 20, 7, 3)});
  trails.add(now);
  TestPicture picture("RGB", 64, 40);
  auto canvas = picture.canvas();
  draw(now, {.line_width = 1, .point_size = 0}, nullptr, &canvas, &trails);
  EXPECT_EQ(pixel(picture, 30, 19), class_color(7));
  EXPECT_EQ(pixel(picture, 48, 18), class_color(3)) << "the box has the colour of its class";
  EXPECT_EQ(pixel(picture, 5, 19), (Rgb{7, 7, 7}));
}

TEST(TrackColors, StayWithTheTrackInAnyRow) {
  const Style style{.line_width = 1, .point_size = 0, .has_track_colors = true};
  for (const bool is_first : {true, false}) {
    auto now = rows({row(10, 20, 7, 3), row(30, 20, 0, 5)});
    if (!is_first) std::swap(now.rows[0], now.rows[1]);
    TestPicture picture("RGB", 64, 40);
    auto canvas = picture.canvas();
    draw(now, style, nullptr, &canvas);
    EXPECT_EQ(pixel(picture, 8, 18), class_color(7));
    EXPECT_EQ(pixel(picture, 28, 18), class_color(5)) << "without a track";
  }
}

}  // namespace trails_test
}  // namespace weir::draw
