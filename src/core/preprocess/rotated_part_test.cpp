// Rotated regions against unrotated ones, quarter turns and closed forms.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/preprocess/rotated_part.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <numbers>

#include "core/preprocess/boxes.hpp"
#include "core/preprocess/plan_reference_test_support.hpp"

namespace weir::preprocess {
namespace rotated_part_test {

using testing::Pixels;

constexpr double kQuarter = std::numbers::pi / 2;

Preparation prepare(const Picture& source, uint32_t width, uint32_t height) {
  Preparation out;
  out.source = source;
  out.width = width, out.height = height;
  out.type = ElementType::Float32;
  out.layout = Layout::Nchw;
  return out;
}

std::vector<float> run(const Preparation& preparation, const Pixels& pixels) {
  const auto plan = PreprocessPlan::make(preparation);
  EXPECT_TRUE(plan);
  std::vector<float> out(*preparation.tensor().bytes() / sizeof(float));
  auto workspace = plan->workspace();
  EXPECT_TRUE(plan->run(pixels.planes, std::as_writable_bytes(std::span(out)), &workspace));
  return out;
}

TEST(RotatedPart, WithoutATurnEqualsTheUnrotatedRegion) {
  for (const char* format : {"RGB", "GRAY8", "NV12", "I420", "YUY2", "BGRx"})
    for (const bool is_cosited : {false, true})
      for (const Fit fit : {Fit::Stretch, Fit::Letterbox, Fit::CentreCrop}) {
        const Pixels pixels(format, 37, 29, 3, 5);
        // Large steps: samples beyond the region, which only a rotated one uses, have no weight.
        auto p = prepare(pixels.picture, 10, 8);
        p.source.cosited_columns = p.source.cosited_rows = is_cosited;
        p.fit = fit;
        p.padding = 9;
        p.region = Roi{-4, 6, 30, 33};
        const auto wanted = run(p, pixels);
        p.region->rotation = 1e-12;
        const auto got = run(p, pixels);
        ASSERT_EQ(got.size(), wanted.size());
        for (size_t i = 0; i < got.size(); ++i)
          ASSERT_NEAR(got[i], wanted[i], 1.0 / 16)
              << format << " " << static_cast<int>(fit) << " " << i;
      }
}

// Clockwise by 90 degrees: the upper edge of the tensor is the right edge of the region.
TEST(RotatedPart, AQuarterTurnExchangesRowsAndColumns) {
  const Pixels pixels("GRAY8", 10, 10);
  for (const Resize resize : {Resize::Nearest, Resize::Bilinear, Resize::Area}) {
    auto p = prepare(pixels.picture, 4, 4);
    p.order = ChannelOrder::Gray;
    p.resize = resize;
    p.region = Roi{.x = 2, .y = 3, .width = 4, .height = 4, .rotation = kQuarter};
    const auto got = run(p, pixels);
    for (int64_t y = 0; y < 4; ++y)
      for (int64_t x = 0; x < 4; ++x)
        EXPECT_NEAR(got[static_cast<size_t>(4 * y + x)], pixels.sample(0, 5 - y, 3 + x), 1e-3);
  }
}

TEST(RotatedPart, AreaIsTheMeanOfThePixels) {
  const Pixels pixels("GRAY8", 8, 8);
  auto p = prepare(pixels.picture, 2, 2);
  p.order = ChannelOrder::Gray;
  p.resize = Resize::Area;
  p.region = Roi{.x = 0, .y = 0, .width = 8, .height = 8, .rotation = 2 * kQuarter};
  const auto got = run(p, pixels);
  for (int64_t y = 0; y < 2; ++y)
    for (int64_t x = 0; x < 2; ++x) {
      double sum = 0;
      for (int64_t i = 0; i < 16; ++i)
        sum += pixels.sample(0, 4 * (1 - x) + i % 4, 4 * (1 - y) + i / 4);
      EXPECT_NEAR(got[static_cast<size_t>(2 * y + x)], sum / 16, 1e-3);
    }
}

TEST(RotatedPart, PadsOutsideThePictureAndMapsBack) {
  const Pixels pixels("GRAY8", 10, 10);
  auto p = prepare(pixels.picture, 6, 6);
  p.order = ChannelOrder::Gray;
  p.padding = 200;
  p.region = Roi{.x = 7, .y = 2, .width = 6, .height = 6, .rotation = kQuarter / 2};
  const auto map = make_source_map(p);
  const Point centre = map.to_source({3, 3}), corner = map.to_source({0, 0});
  EXPECT_NEAR(centre.x, 10, 1e-9);
  EXPECT_NEAR(centre.y, 5, 1e-9);
  EXPECT_NEAR(corner.x, 10, 1e-9) << "the left upper corner is now at the top";
  EXPECT_NEAR(corner.y, 5 - 3 * std::numbers::sqrt2, 1e-9);
  const auto got = run(p, pixels);
  size_t padded = 0;
  for (uint32_t y = 0; y < 6; ++y)
    for (uint32_t x = 0; x < 6; ++x) {
      const Point at = map.to_source({x + 0.5, y + 0.5});
      const bool is_inside = at.x >= 0 && at.x < 10 && at.y >= 0 && at.y < 10;
      EXPECT_TRUE(is_inside || got[6 * y + x] == 200) << x << " " << y;
      padded += !is_inside;
    }
  EXPECT_GT(padded, 10u);
  EXPECT_LT(padded, 26u);
  const Rect all{0, 0, 10, 10};
  EXPECT_FALSE(check_region(p, all, {.x = 30, .y = 0, .width = 6, .height = 6, .rotation = 1}));
}

TEST(RotatedPart, AShorterPictureIsAnError) {
  Pixels pixels("GRAY8", 10, 10);
  auto p = prepare(pixels.picture, 4, 4);
  p.order = ChannelOrder::Gray;
  p.region = Roi{.x = 0, .y = 0, .width = 4, .height = 4, .rotation = 1};
  const auto plan = PreprocessPlan::make(p);
  ASSERT_TRUE(plan);
  pixels.memory.pop_back();
  for (Plane& plane : pixels.planes) plane.memory = pixels.memory;
  std::vector<std::byte> out(*p.tensor().bytes());
  auto workspace = plan->workspace();
  EXPECT_FALSE(plan->run(pixels.planes, out, &workspace));
}

// MediaPipe's hand: the box moves half its height along its own up, and grows 2.6 times.
TEST(RegionShape, MovesAlongTheSidesOfARotatedBox) {
  const PictureBox box{.left = 90, .top = 190, .right = 110, .bottom = 230};  // around 100, 210
  PictureBox turned_box = box;
  turned_box.rotation = kQuarter;
  const RegionShape shape{
      .shift_y = -0.5, .is_square = true, .scale = 2.5, .follows_rotation = true};
  EXPECT_EQ(make_region(box, shape), (Roi{.x = 50, .y = 140, .width = 100, .height = 100}));
  const auto turned = make_region(turned_box, shape);
  EXPECT_EQ(turned.x, 70) << "its up is to the right";
  EXPECT_EQ(turned.y, 160);
  EXPECT_EQ(turned.width, 100);
  EXPECT_NEAR(turned.rotation, kQuarter, 1e-6);
  EXPECT_EQ(make_region(turned_box, {}), (Roi{.x = 80, .y = 200, .width = 40, .height = 20}))
      << "the upright box around it";
  EXPECT_EQ(make_region({.left = 0, .top = 0, .right = 4, .bottom = 2, .row = 3}, {.scale = 2}),
            (Roi{.x = -2, .y = -1, .width = 8, .height = 4, .row = 3}));
  EXPECT_EQ(make_region({.left = 0, .top = 0, .right = NAN, .bottom = 4}, shape).width, 0);
}

}  // namespace rotated_part_test
}  // namespace weir::preprocess
