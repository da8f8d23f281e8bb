// Placement of pictures in tensors, and the source map back.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/preprocess/placement.hpp"

#include <gtest/gtest.h>

namespace weir::preprocess {
namespace placement_test {

Preparation preparation(uint32_t width, uint32_t height, uint32_t to_width, uint32_t to_height,
                        Fit fit) {
  Preparation p;
  p.source.format = *picture_format("RGB");
  p.source.width = width;
  p.source.height = height;
  p.width = to_width;
  p.height = to_height;
  p.fit = fit;
  return p;
}

TEST(Placement, StretchedFillsTheTensor) {
  const auto place = preprocess::place(preparation(1920, 1080, 224, 200, Fit::Stretch));
  EXPECT_EQ(place.source, (Rect{0, 0, 1920, 1080}));
  EXPECT_EQ(place.content, (Rect{0, 0, 224, 200}));
}

TEST(Placement, LetterboxedIsCentred) {
  EXPECT_EQ(place(preparation(1920, 1080, 640, 640, Fit::Letterbox)).content,
            (Rect{0, 140, 640, 360}));
  EXPECT_EQ(place(preparation(1080, 1920, 640, 640, Fit::Letterbox)).content,
            (Rect{140, 0, 360, 640}));
  EXPECT_EQ(place(preparation(100, 100, 64, 64, Fit::Letterbox)).content, (Rect{0, 0, 64, 64}));
  // 7 columns of a 5x3 picture need 4.2 rows, rounded to 4.
  EXPECT_EQ(place(preparation(5, 3, 7, 9, Fit::Letterbox)).content, (Rect{0, 2, 7, 4}));
}

TEST(Placement, LetterboxedIsNeverEmpty) {
  EXPECT_EQ(place(preparation(60000, 1, 10, 10, Fit::Letterbox)).content, (Rect{0, 4, 10, 1}));
}

TEST(Placement, CentreCropTakesTheMiddle) {
  EXPECT_EQ(place(preparation(1920, 1080, 224, 224, Fit::CentreCrop)).source,
            (Rect{420, 0, 1080, 1080}));
  EXPECT_EQ(place(preparation(100, 300, 20, 10, Fit::CentreCrop)).source, (Rect{0, 125, 100, 50}));
}

TEST(Placement, StaysWithinTheGivenCrop) {
  auto p = preparation(100, 100, 10, 10, Fit::CentreCrop);
  p.crop = Rect{20, 30, 40, 20};
  EXPECT_EQ(place(p).source, (Rect{30, 30, 20, 20}));
  p.fit = Fit::Stretch;
  EXPECT_EQ(place(p).source, (Rect{20, 30, 40, 20}));
}

TEST(SourceMap, MapsCornersToCornersAndBack) {
  auto p = preparation(1920, 1080, 640, 640, Fit::Letterbox);
  const auto map = make_source_map(p);
  const Point corner = map.to_source({0, 140}), opposite = map.to_source({640, 500});
  EXPECT_DOUBLE_EQ(corner.x, 0);
  EXPECT_DOUBLE_EQ(corner.y, 0);
  EXPECT_DOUBLE_EQ(opposite.x, 1920);
  EXPECT_DOUBLE_EQ(opposite.y, 1080);
  EXPECT_EQ(map.source_width, 1920u);
  EXPECT_EQ(map.height, 640u);
  EXPECT_EQ(map.x_dimension, 1);
  p.layout = Layout::Nchw;
  EXPECT_EQ(make_source_map(p).x_dimension, 0);
  EXPECT_EQ(make_source_map(p).y_dimension, 1);
  p.crop = Rect{101, 33, 517, 211};
  for (const Fit fit : {Fit::Stretch, Fit::Letterbox, Fit::CentreCrop}) {
    p.fit = fit;
    const auto cropped = make_source_map(p);
    const Point there = cropped.to_source({12.5, 77});
    EXPECT_NEAR(cropped.to_tensor(there).x, 12.5, 1e-9);
    EXPECT_NEAR(cropped.to_tensor(there).y, 77, 1e-9);
  }
}

}  // namespace placement_test
}  // namespace weir::preprocess
