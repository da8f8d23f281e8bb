// Tests the cascade's arithmetic on hand-made values.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "cascade.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace mtcnn {
namespace cascade_test {

using weir::Box;

// MANIFEST: "size ceil(H * s) x ceil(W * s)" with s = 12 / minimum * 0.709^k.
TEST(Pyramid, FollowsFromPictureAndSmallestFace) {
  const auto layers = pyramid({1920, 1080}, 40);
  ASSERT_EQ(layers.size(), 10u);
  EXPECT_EQ(layers[0].width, 576u);
  EXPECT_EQ(layers[0].height, 324u);
  EXPECT_EQ(layers[1].width, 409u);  // 576 * 0.709 = 408.4
  EXPECT_EQ(layers[1].height, 230u);
  EXPECT_EQ(layers[9].height, 15u);
  EXPECT_TRUE(pyramid({100, 30}, 40).empty()) << "smaller than a face";
  EXPECT_EQ(pyramid({100, 40}, 40).size(), 1u);
}

// A map of 3 x 2 places with one face.
struct Map {
  std::vector<float> face = std::vector<float>(12, 0.f), box = std::vector<float>(24, 0.f);
  ProposalMap planes() const { return {{3, 2}, face, box, {1, 3, 6}, {1, 3, 6}}; }
};

TEST(Propose, FindsThePlaceInThePicture) {
  Map map;
  map.face[6 + 3 + 2] = 0.9f;                                      // place (2, 1)
  map.box[0 * 6 + 3 + 2] = 0.25f;                                  // the left edge moves right
  map.box[3 * 6 + 3 + 2] = -0.5f;                                  // the lower edge moves up
  const auto found = propose(map.planes(), {20, 10}, {200, 200});  // scaled by 10 in x and 20 in y
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].box, (Box{40, 40, 160, 280}));
  EXPECT_EQ(found[0].moved, (Box{70, 40, 160, 160}));
  EXPECT_FLOAT_EQ(found[0].score, 0.9f);
}

TEST(Propose, ReadsChannelsBesideEachOther) {
  std::vector<float> face(12, 0.f), box(24, 0.f);
  face[(1 * 3 + 2) * 2 + 1] = 0.9f;
  box[(1 * 3 + 2) * 4 + 0] = 0.25f;
  const auto found = propose({{3, 2}, face, box, {2, 6, 1}, {4, 12, 1}}, {20, 10}, {200, 200});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].moved, (Box{70, 40, 160, 280}));
}

TEST(Propose, LeavesOutWhatIsUnsureOrNoNumber) {
  Map map;
  map.face[6] = 0.59f;
  map.face[7] = NAN;
  EXPECT_TRUE(propose(map.planes(), {20, 10}, {200, 200}).empty());
}

TEST(Join, MakesSquaresAndLeavesOutWhatIsOutside) {
  const std::vector<Candidate> all{{{0, 0, 10, 10}, {0, 0, 10, 20}, 0.9f},
                                   {{0, 0, 10, 10}, {0, 0, 10, 10}, 0.8f},           // a duplicate
                                   {{50, 50, 60, 60}, {-90, -90, -80, -80}, 0.7f}};  // outside
  EXPECT_EQ(join(all, {100, 100}), (std::vector<Box>{{-5, 0, 15, 20}}));
}

// R-Net's input has 24 pixels: at least two of 48 picture pixels must be visible.
TEST(Join, LeavesOutWhatIsHardlySeen) {
  const auto seen = [](const Box& box) { return join({{{}, box, 0.9f}}, {100, 100}).size() == 1; };
  EXPECT_TRUE(seen({-46, 0, 2, 48}));
  EXPECT_FALSE(seen({-47, 0, 1, 48}));
  EXPECT_TRUE(seen({0, 98, 48, 146}));
  EXPECT_FALSE(seen({0, 99, 48, 147}));
  EXPECT_FALSE(seen({99, 99, 147, 147}));
}

TEST(Faces, LandmarksAreSharesOfTheRegion) {
  const std::vector<Box> regions{{100, 200, 200, 300}, {0, 0, 10, 10}};
  const std::vector<float> face{0.1f, 0.9f, 0.5f, 0.5f}, box(8, 0.f);
  std::vector<float> points(20, 0.f);
  points[0] = 0.3f, points[5] = 0.4f;  // the left eye
  const auto found = faces(regions, face, box, points);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].box, regions[0]);
  EXPECT_FLOAT_EQ(found[0].points[0], 130);
  EXPECT_FLOAT_EQ(found[0].points[1], 240);
}

TEST(Refine, KeepsTheSureOnes) {
  const std::vector<Box> regions{{0, 0, 10, 10}, {20, 20, 40, 40}};
  const std::vector<float> face{0.9f, 0.1f, 0.2f, 0.8f}, box{0, 0, 0, 0, 0, 0, 0, 0.5f};
  EXPECT_EQ(refine(regions, face, box, {100, 100}), (std::vector<Box>{{15, 20, 45, 50}}));
  EXPECT_TRUE(refine({}, {}, {}, {100, 100}).empty());
}

}  // namespace cascade_test
}  // namespace mtcnn
