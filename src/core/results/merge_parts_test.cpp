// Tests of objects in overlapping parts of a picture.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/results/merge_parts.hpp"

#include <gtest/gtest.h>

#include <array>

namespace weir::results {
namespace merge_parts_test {

// Two tiles of 100 x 100 pixels that have the columns 80 to 100 in common.
const std::vector<Box> kTiles{{0, 0, 100, 100}, {80, 0, 180, 100}};

Object seen(Box box, float score, int32_t class_index = 0) {
  Object out;
  out.box = box, out.score = score, out.class_index = class_index;
  return out;
}

FrameResults merged(std::vector<Object> objects, const std::vector<uint32_t>& part_of,
                    size_t max = 100, const std::vector<Box>& tiles = kTiles,
                    Size picture = {180, 100}) {
  FrameResults out;
  out.objects = std::move(objects);
  out.points_per_object = 1;
  for (size_t i = 0; i < out.objects.size(); ++i)
    out.points.push_back({static_cast<float>(i), 0, 1});
  merge_parts({.boxes = tiles, .part_of = part_of, .picture = picture}, 0.45f, max, &out);
  return out;
}

TEST(MergeParts, AnObjectInBothPartsIsOne) {
  const auto out = merged({seen({82, 20, 98, 40}, 0.6f), seen({83, 20, 98, 40}, 0.8f)}, {0, 1});
  ASSERT_EQ(out.objects.size(), 1u);
  EXPECT_EQ(out.objects[0], seen({83, 20, 98, 40}, 0.8f));
  ASSERT_EQ(out.points.size(), 1u);
  EXPECT_EQ(out.points[0].x, 1);
}

TEST(MergeParts, APieceBelongsToTheWhole) {
  // The first tile ends within the object, the second one has all of it.
  const auto out = merged({seen({85, 20, 100, 40}, 0.9f), seen({85, 20, 150, 40}, 0.7f)}, {0, 1});
  ASSERT_EQ(out.objects.size(), 1u);
  EXPECT_EQ(out.objects[0], seen({85, 20, 150, 40}, 0.9f));
  EXPECT_EQ(out.points[0].x, 1) << "of the whole object";
}

TEST(MergeParts, TwoPiecesAreTheBoxAroundBoth) {
  const auto out = merged({seen({20, 20, 100, 40}, 0.9f), seen({80, 21, 150, 41}, 0.7f)}, {0, 1});
  EXPECT_EQ(out.objects.size(), 2u) << "only a quarter of a piece is in common";
  const auto near = merged({seen({70, 20, 100, 40}, 0.9f), seen({80, 21, 110, 41}, 0.7f)}, {0, 1});
  ASSERT_EQ(near.objects.size(), 1u);
  EXPECT_EQ(near.objects[0], seen({70, 20, 110, 41}, 0.9f));
}

TEST(MergeParts, PiecesInThreePartsAreOne) {
  const std::vector<Box> tiles{{0, 0, 100, 100}, {50, 0, 150, 100}, {100, 0, 200, 100}};
  const Box left{20, 20, 100, 40}, middle{50, 20, 150, 40}, right{100, 20, 190, 40};
  for (const auto& scores :
       {std::array{0.9f, 0.7f, 0.8f}, {0.8f, 0.9f, 0.7f}, {0.7f, 0.8f, 0.9f}}) {
    const auto out =
        merged({seen(left, scores[0]), seen(middle, scores[1]), seen(right, scores[2])}, {0, 1, 2},
               100, tiles, {200, 100});
    ASSERT_EQ(out.objects.size(), 1u) << scores[0];
    EXPECT_EQ(out.objects[0], seen({20, 20, 190, 40}, 0.9f));
    EXPECT_EQ(out.points.size(), 1u);
  }
}

TEST(MergeParts, OthersStay) {
  const std::vector<Object> objects{
      seen({82, 20, 98, 40}, 0.5f), seen({82, 20, 98, 40}, 0.9f, 1),  // another class
      seen({10, 10, 60, 60}, 0.7f), seen({12, 12, 62, 62}, 0.6f),     // of one part
      seen({84, 22, 90, 30}, 0.8f)};                                  // small, within another
  const auto out = merged(objects, {0, 1, 0, 0, 1});
  ASSERT_EQ(out.objects.size(), 5u);
  EXPECT_EQ(out.objects[0], objects[1]) << "best first";
  EXPECT_EQ(merged(objects, {0, 1, 0, 0, 1}, 2).objects.size(), 2u);
}

TEST(MergeParts, ASmallObjectWithinALargeCutOneIsAnother) {
  const std::vector<Object> objects{seen({10, 5, 100, 95}, 0.9f), seen({84, 22, 96, 40}, 0.6f)};
  const auto out = merged(objects, {0, 1});
  ASSERT_EQ(out.objects.size(), 2u);
  EXPECT_EQ(out.objects[0], objects[0]);
  EXPECT_EQ(out.objects[1], objects[1]);
}

TEST(MergeParts, TheEdgeOfThePictureCutsNothing) {
  // Small and at the upper edge of the picture, within a large one of the other tile.
  const std::vector<Object> objects{seen({10, 0, 98, 95}, 0.9f), seen({84, 0, 96, 20}, 0.6f)};
  EXPECT_EQ(merged(objects, {0, 1}).objects.size(), 2u);
  const std::vector<Object> at_bottom{seen({10, 5, 98, 100}, 0.9f), seen({84, 80, 96, 100}, 0.6f)};
  EXPECT_EQ(merged(at_bottom, {0, 1}).objects.size(), 2u);
}

TEST(MergeParts, MoreObjectsThanAreComparedStay) {
  std::vector<Object> objects;
  std::vector<uint32_t> part_of;
  for (int i = 0; i < 9000; ++i) {  // of as many classes, so that none is another
    objects.push_back(seen({82, 20, 98, 40}, 0.5f, i));
    part_of.push_back(0);
  }
  for (int i = 0; i < 9000; ++i) {
    objects.push_back(seen({10, 20, 30, 40}, 0.25f, i));  // in no other tile
    part_of.push_back(0);
  }
  EXPECT_EQ(merged(objects, part_of, 20000).objects.size(), 18000u);
}

TEST(Tiles, CoverThePictureAsAGrid) {
  const Size picture{180, 150};
  const std::vector<Box> grid{
      {0, 0, 100, 100}, {80, 0, 180, 100}, {0, 75, 100, 150}, {80, 75, 180, 150}};
  EXPECT_TRUE(are_tiles(grid, picture));
  EXPECT_TRUE(are_tiles(kTiles, {180, 100}));
  EXPECT_TRUE(are_tiles(std::vector<Box>{{-20, -20, 90, 120}, {90, -20, 200, 120}}, {180, 100}));
  EXPECT_FALSE(are_tiles(grid, {})) << "not known";
  EXPECT_FALSE(are_tiles(std::span(grid).first(3), picture)) << "a corner is missing";
  EXPECT_FALSE(are_tiles(std::span(grid).first(2), picture));
  EXPECT_FALSE(are_tiles(std::vector<Box>{{0, 0, 180, 150}}, picture)) << "one box";
  EXPECT_FALSE(are_tiles(std::vector<Box>{{10, 10, 60, 60}, {40, 30, 120, 90}}, picture));
}

}  // namespace merge_parts_test
}  // namespace weir::results
