// Tests of zones on a picture.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/draw/zone_marks.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/draw/draw_test_support.hpp"
#include "core/draw/overlay.hpp"

namespace weir::draw {
namespace zone_marks_test {

bool is_painted(TestPicture& picture, int64_t x, int64_t y) {
  return *picture.sample(0, x, y) != 7;
}
const zone::Zone kYard{.name = "yard", .points = {{20, 20}, {60, 20}, {60, 50}, {20, 50}}};
const zone::Zone kGate{.name = "gate", .kind = zone::Kind::Line, .points = {{10, 40}, {90, 40}}};

Detections with(std::vector<zone::Zone> zones) {
  Detections out;
  out.zones = std::make_shared<const zone::ZoneSet>(zone::ZoneSet{std::move(zones), {}, {}});
  return out;
}

TEST(ZoneMarks, AnAreaIsItsOutline) {
  TestPicture picture("GRAY8", 100, 80);
  auto canvas = picture.canvas();
  draw(with({kYard}), {.line_width = 2}, nullptr, &canvas);
  for (int64_t x = 22; x < 58; ++x) {
    EXPECT_TRUE(is_painted(picture, x, 20)) << x;
    EXPECT_TRUE(is_painted(picture, x, 49)) << x;
    EXPECT_FALSE(is_painted(picture, x, 35)) << x;
    EXPECT_FALSE(is_painted(picture, x, 10)) << x;
  }
  EXPECT_TRUE(is_painted(picture, 20, 30));
  EXPECT_TRUE(is_painted(picture, 59, 30));
}

TEST(ZoneMarks, ALineHasAnArrowForward) {
  TestPicture picture("GRAY8", 100, 80);
  auto canvas = picture.canvas();
  draw(with({kGate}), {.line_width = 2}, nullptr, &canvas);
  EXPECT_TRUE(is_painted(picture, 12, 40));
  EXPECT_TRUE(is_painted(picture, 88, 40));
  EXPECT_TRUE(is_painted(picture, 50, 55)) << "below, to the right of who looks from left to right";
  EXPECT_FALSE(is_painted(picture, 50, 25));
  EXPECT_FALSE(is_painted(picture, 30, 50));
}

TEST(ZoneMarks, CanBeSwitchedOff) {
  TestPicture picture("GRAY8", 100, 80);
  auto canvas = picture.canvas();
  draw(with({kYard, kGate}), {.shows_zones = false}, nullptr, &canvas);
  EXPECT_EQ(picture, TestPicture("GRAY8", 100, 80));
}

TEST(ZoneMarks, AreScaledToThePicture) {
  auto d = with({kYard});
  d.picture_width = 200, d.picture_height = 160;
  TestPicture picture("GRAY8", 100, 80);
  auto canvas = picture.canvas();
  draw(d, {.line_width = 1}, nullptr, &canvas);
  EXPECT_TRUE(is_painted(picture, 20, 9));
  EXPECT_FALSE(is_painted(picture, 50, 20));
}

TEST(ZoneMarks, FarCornersAreClippedInEveryFormat) {
  for (const auto& format : every_format()) {
    TestPicture picture(format, 33, 21);
    auto canvas = picture.canvas();
    draw(with({{.name = "a", .points = {{-1e6, -1e6}, {1e6, -1e6}, {1e6, 1e6}}},
               {.name = "b", .kind = zone::Kind::Line, .points = {{-1e6, 5}, {1e6, 9}}}}),
         {.line_width = 3}, nullptr, &canvas);
  }
}

TEST(ZoneMarks, TextsHaveTheCounts) {
  EXPECT_EQ(text_of_zone(kYard, {.inside = 2, .entered = 5}), "yard: 2 inside, 5 entered");
  EXPECT_EQ(text_of_zone(kGate, {.forward = 3, .backward = 0}), "gate: 3 forward, 0 backward");
  EXPECT_EQ(text_of_zone(kYard, {}), "yard");
  EXPECT_EQ(text_of_zone(kGate, {}), "gate");
  EXPECT_EQ(text_of_zone(kYard, {.inside = -5, .entered = INFINITY}), "yard: ? inside, ? entered");
}

// Texts are blocks of 2 x 4 pixels for each character.
struct Blocks : TextPainter {
  Mask paint(const std::string& text) override {
    texts.push_back(text);
    const auto width = static_cast<uint32_t>(2 * text.size());
    return {width, 4, std::vector<uint8_t>(width * 4, 255)};
  }
  std::vector<std::string> texts;
};

TEST(ZoneMarks, LabelsStandAtTheZones) {
  auto d = with({kYard, kGate});
  d.zone_totals = {{.inside = 2, .entered = 5}};
  TestPicture picture("GRAY8", 100, 80);
  auto canvas = picture.canvas();
  auto painter = std::make_shared<Blocks>();
  Labels labels({}, false, painter, picture.picture.format);
  draw(d, {}, &labels, &canvas);
  EXPECT_EQ(painter->texts, (std::vector<std::string>{"yard: 2 inside, 5 entered", "gate"}));
  EXPECT_TRUE(is_painted(picture, 30, 17)) << "above the yard";
}

}  // namespace zone_marks_test
}  // namespace weir::draw
