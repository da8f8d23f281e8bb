// Tests of the places of labels.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/draw/label_layout.hpp"

#include <gtest/gtest.h>

#include <random>

namespace weir::draw {
namespace label_layout_test {

constexpr Area kPicture{0, 0, 200, 100};

TEST(LabelLayout, StandsAboveItsBox) {
  EXPECT_EQ(LabelLayout(kPicture).place({50, 50, 90, 80}, 30, 10, 1), (Area{50, 40, 80, 50}));
}

TEST(LabelLayout, GoesInsideWhereThereIsNoRoomAbove) {
  EXPECT_EQ(LabelLayout(kPicture).place({50, 4, 90, 80}, 30, 10, 1), (Area{50, 4, 80, 14}));
  EXPECT_EQ(LabelLayout(kPicture).place({50, -20, 90, 80}, 30, 10, 1), (Area{50, 0, 80, 10}));
}

TEST(LabelLayout, IsMovedIntoThePicture) {
  EXPECT_EQ(LabelLayout(kPicture).place({190, 50, 230, 80}, 30, 10, 1), (Area{170, 40, 200, 50}));
  EXPECT_EQ(LabelLayout(kPicture).place({-30, 50, 20, 80}, 30, 10, 1), (Area{0, 40, 30, 50}));
}

TEST(LabelLayout, LabelsOfEqualBoxesDoNotCoverEachOther) {
  LabelLayout layout(kPicture);
  const Area box{50, 30, 90, 70};
  EXPECT_EQ(layout.place(box, 30, 10, 1), (Area{50, 20, 80, 30}));
  EXPECT_EQ(layout.place(box, 30, 10, 1), (Area{50, 30, 80, 40}));
  EXPECT_EQ(layout.place(box, 30, 10, 1), (Area{50, 70, 80, 80}));
}

TEST(LabelLayout, RandomLabelsNeverMeet) {
  std::mt19937 random(2);
  for (int run = 0; run < 50; ++run) {
    LabelLayout layout(kPicture);
    std::vector<Area> placed;
    for (int i = 0; i < 40; ++i) {
      const auto x = static_cast<int64_t>(random() % 220) - 20;
      const auto y = static_cast<int64_t>(random() % 120) - 20;
      const Area area = layout.place({x, y, x + 30, y + 20}, 20 + int64_t(random() % 30), 8, 2);
      if (area.empty()) continue;
      EXPECT_EQ(area.left % 2, 0);
      EXPECT_EQ(area.top % 2, 0);
      EXPECT_GE(area.top, 0);
      EXPECT_LE(area.bottom, kPicture.bottom);
      for (const Area& other : placed) EXPECT_TRUE(common_part(area, other).empty());
      placed.push_back(area);
    }
    EXPECT_GT(placed.size(), 15u);
  }
}

TEST(LabelLayout, AListGoesDownFromTheTopOfItsBox) {
  LabelLayout layout(kPicture);
  EXPECT_EQ(layout.place_in_list(kPicture, 30, 10, 1), (Area{0, 0, 30, 10}));
  EXPECT_EQ(layout.place_in_list(kPicture, 40, 10, 1), (Area{0, 10, 40, 20}));
  EXPECT_EQ(layout.place({0, 20, 50, 90}, 30, 10, 1), (Area{0, 20, 30, 30}));
  EXPECT_EQ(layout.place_in_list(kPicture, 40, 10, 1), (Area{0, 30, 40, 40}));
  EXPECT_TRUE(LabelLayout(kPicture).place_in_list({300, 0, 320, 50}, 40, 10, 1).empty());
}

TEST(LabelLayout, BoxesOutsideHaveNoLabel) {
  EXPECT_TRUE(LabelLayout(kPicture).place({300, 50, 340, 80}, 30, 10, 1).empty());
  EXPECT_TRUE(LabelLayout(kPicture).place({50, 30, 50, 30}, 30, 10, 1).empty());
}

TEST(LabelLayout, ALabelThatIsLargerThanThePictureBeginsAtItsEdge) {
  EXPECT_EQ(LabelLayout({0, 0, 20, 8}).place({5, 2, 9, 6}, 30, 10, 1).left, 0);
}

}  // namespace label_layout_test
}  // namespace weir::draw
