// Tests of what is drawn besides upright boxes and points: masks, class maps, rotated boxes,
// skeletons, and labels that share a picture.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cmath>
#include <numbers>

#include "core/draw/draw_test_support.hpp"
#include "core/draw/overlay.hpp"
#include "core/draw/skeleton.hpp"

namespace weir::draw {
namespace overlay_results_test {

constexpr Style kNoLines{.line_width = 0, .point_size = 0};

Detection box_of(double x1, double y1, double x2, double y2, float score = 1, uint32_t c = 0) {
  Detection out;
  out.x1 = x1, out.y1 = y1, out.x2 = x2, out.y2 = y2;
  out.score = score, out.class_index = c;
  return out;
}

// Whether the pixel of a gray picture is not the ground's.
bool is_painted(TestPicture& picture, int64_t x, int64_t y) {
  return *picture.sample(0, x, y) != 7;
}

// Texts are blocks of 6 x 10 pixels for each character.
struct Blocks : TextPainter {
  Mask paint(const std::string& text) override {
    texts.push_back(text);
    const auto width = static_cast<uint32_t>(6 * text.size());
    return {width, 10, std::vector<uint8_t>(width * 10, 255)};
  }
  std::vector<std::string> texts;
};

TEST(OverlayResults, AMaskTintsTheInsideOfItsBox) {
  Detections d;
  d.rows = {box_of(10, 10, 30, 30)};
  d.rows[0].mask = 0;
  d.masks = {{2, 1, {255, 0}}};  // the left half
  TestPicture picture("GRAY8", 40, 40);
  auto canvas = picture.canvas();
  draw(d, kNoLines, nullptr, &canvas);
  for (int64_t y = 0; y < 40; ++y)
    for (int64_t x = 0; x < 40; ++x)
      EXPECT_EQ(is_painted(picture, x, y), x >= 10 && x < 20 && y >= 10 && y < 30) << x << "," << y;
}

TEST(OverlayResults, MasksCanBeSwitchedOff) {
  Detections d;
  d.rows = {box_of(10, 10, 30, 30)};
  d.rows[0].mask = 0;
  d.masks = {{1, 1, {255}}};
  d.class_maps = {{0, 0, 40, 40, 1, 1, {3}}};
  TestPicture picture("NV12", 40, 40);
  auto canvas = picture.canvas();
  draw(d, {.line_width = 0, .point_size = 0, .mask_opacity = 0}, nullptr, &canvas);
  EXPECT_EQ(picture, TestPicture("NV12", 40, 40));
}

TEST(OverlayResults, AClassMapTintsAllButTheBackground) {
  Detections d;
  d.class_maps = {{0, 0, 40, 20, 2, 1, {0, 5}}};
  TestPicture picture("GRAY8", 40, 40);
  auto canvas = picture.canvas();
  draw(d, kNoLines, nullptr, &canvas);
  for (int64_t y = 0; y < 40; ++y)
    for (int64_t x = 0; x < 40; ++x)
      EXPECT_EQ(is_painted(picture, x, y), x >= 20 && y < 20) << x << "," << y;
}

TEST(OverlayResults, DepthsCoverThePictureWithTheirColours) {
  Detections d;
  d.class_maps = {{0, 0, 40, 20, 2, 1, {0, 255}, true}};
  TestPicture picture("GRAY8", 40, 40), expected("GRAY8", 40, 40);
  auto canvas = picture.canvas();
  draw(d, kNoLines, nullptr, &canvas);
  auto filled = expected.canvas();
  filled.fill({0, 0, 20, 20}, make_paint(filled.picture(), {68, 1, 84}));
  filled.fill({20, 0, 40, 20}, make_paint(filled.picture(), {253, 231, 37}));
  EXPECT_EQ(picture, expected);
}

TEST(OverlayResults, CoordinatesOfAnotherPictureAreScaled) {
  Detections d;
  d.picture_width = 400, d.picture_height = 80;
  d.class_maps = {{100, 0, 200, 80, 1, 1, {1}}};
  TestPicture picture("GRAY8", 40, 40);
  auto canvas = picture.canvas();
  draw(d, kNoLines, nullptr, &canvas);
  EXPECT_FALSE(is_painted(picture, 9, 5));
  EXPECT_TRUE(is_painted(picture, 10, 39));
  EXPECT_TRUE(is_painted(picture, 19, 5));
  EXPECT_FALSE(is_painted(picture, 20, 5));
}

TEST(OverlayResults, ARotatedBoxIsDrawnAlongItsEdges) {
  Detections d;
  d.rows = {box_of(10, 25, 50, 35)};
  d.rows[0].rotation = std::numbers::pi_v<float> / 2;
  TestPicture picture("GRAY8", 60, 60);
  auto canvas = picture.canvas();
  EXPECT_EQ(draw(d, {.line_width = 2, .point_size = 0}, nullptr, &canvas).boxes, 1u);
  // A quarter turn: from 25 to 35 across, from 10 to 50 down.
  EXPECT_TRUE(is_painted(picture, 25, 30));
  EXPECT_TRUE(is_painted(picture, 34, 12));
  EXPECT_TRUE(is_painted(picture, 30, 10));
  EXPECT_TRUE(is_painted(picture, 30, 49));
  EXPECT_FALSE(is_painted(picture, 30, 30));
  EXPECT_FALSE(is_painted(picture, 12, 30));
}

TEST(OverlayResults, BodiesHaveLinesBetweenThePointsThatWereFound) {
  Detections d;
  d.rows = {box_of(0, 0, 100, 100)};
  d.points_per_row = 17;
  d.points.assign(17, {5, 5});
  d.point_scores.assign(17, 0);
  d.points[5] = {20.5, 20.5}, d.points[7] = {20.5, 60.5}, d.points[9] = {60.5, 60.5};
  d.point_scores[5] = d.point_scores[7] = 0.9f;
  const auto drawn = [&] {
    auto picture = std::make_unique<TestPicture>("GRAY8", 100, 100);
    auto canvas = picture->canvas();
    draw(d, {.line_width = 1, .point_size = 3}, nullptr, &canvas);
    return picture;
  };
  EXPECT_TRUE(is_painted(*drawn(), 20, 40));   // shoulder to elbow
  EXPECT_FALSE(is_painted(*drawn(), 40, 60));  // the wrist was not found
  EXPECT_FALSE(is_painted(*drawn(), 5, 5));
  d.point_scores[9] = 0.5f;
  EXPECT_TRUE(is_painted(*drawn(), 40, 60));
}

TEST(OverlayResults, ConnectionsNameExistingPoints) {
  for (const size_t points : {17, 21, 33}) {
    EXPECT_FALSE(get_connections(points).empty());
    for (const auto& [from, to] : get_connections(points)) {
      EXPECT_LT(from, points);
      EXPECT_LT(to, points);
      EXPECT_NE(from, to);
    }
  }
  EXPECT_TRUE(get_connections(5).empty());
  EXPECT_TRUE(get_connections(0).empty());
}

TEST(OverlayResults, TheBestScoreHasTheFirstPlaceForItsLabel) {
  Detections d;
  d.rows = {box_of(20, 30, 80, 90, 0.4f, 1), box_of(20, 30, 80, 90, 0.9f, 2)};
  auto painter = std::make_shared<Blocks>();
  TestPicture picture("RGB", 100, 100);
  Labels labels({{"a", "b", "c"}}, false, painter, picture.picture.format);
  auto canvas = picture.canvas();
  draw(d, kNoLines, &labels, &canvas);
  EXPECT_EQ(painter->texts, (std::vector<std::string>{"c", "b"}));
  // Above the box, and inside it.
  EXPECT_EQ(*picture.sample(0, 20, 21), class_color(2).red);
  EXPECT_EQ(*picture.sample(0, 20, 31), class_color(1).red);
}

TEST(OverlayResults, LabelsShowTextsTracksAndScores) {
  Detections d;
  d.rows = {box_of(20, 30, 80, 90, 0.5f, 0)};
  d.rows[0].text = 0, d.rows[0].track = 12;
  d.texts = {"EXIT"};
  d.scored = true;
  auto painter = std::make_shared<Blocks>();
  TestPicture picture("RGB", 200, 100);
  Labels labels({{"sign"}}, true, painter, picture.picture.format);
  painter->texts.clear();
  auto canvas = picture.canvas();
  draw(d, kNoLines, &labels, &canvas);
  EXPECT_EQ(painter->texts, (std::vector<std::string>{"EXIT", "#12"}));
}

TEST(OverlayResults, SizesFollowTheHeightOfThePicture) {
  EXPECT_EQ(line_width_for(720), 2u);
  EXPECT_EQ(point_size_for(720), 5u);
  EXPECT_EQ(text_size_for(720), 20u);
  EXPECT_EQ(line_width_for(2160), 6u);
  EXPECT_EQ(point_size_for(2160), 15u);
  EXPECT_EQ(text_size_for(2160), 60u);
  EXPECT_EQ(line_width_for(1), 1u);
  EXPECT_EQ(point_size_for(1), 3u);
  EXPECT_EQ(text_size_for(1), 10u);
}

TEST(OverlayResults, LabelsOfThePictureAreAList) {
  Detections d;
  d.rows = {box_of(0, 0, 100, 100, 0.2f, 0), box_of(0, 0, 100, 100, 0.7f, 1)};
  for (Detection& row : d.rows) row.is_label = true;
  TestPicture picture("RGB", 100, 100);
  Labels labels({{"cat", "dog"}}, false, std::make_shared<Blocks>(), picture.picture.format);
  auto canvas = picture.canvas();
  const Drawn drawn = draw(d, {.line_width = 2, .point_size = 0}, &labels, &canvas);
  EXPECT_EQ(drawn.boxes, 0u);
  EXPECT_EQ(*picture.sample(0, 0, 0), class_color(1).red);
  EXPECT_EQ(*picture.sample(0, 0, 10), class_color(0).red);
  EXPECT_EQ(*picture.sample(0, 99, 99), 7);  // no box around the picture
}

}  // namespace overlay_results_test
}  // namespace weir::draw
