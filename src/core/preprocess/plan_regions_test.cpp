// Regions that exceed the picture: padding outside, the same numbers inside.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include <cstring>

#include "core/preprocess/plan_reference_test_support.hpp"
#include "says.hpp"

namespace weir::preprocess {
namespace plan_regions_test {

using testing::Pixels;
using testing::reference;
using testing::run;

Preparation preparation(const Picture& picture, uint32_t width, uint32_t height) {
  Preparation p;
  p.source = picture;
  p.width = width;
  p.height = height;
  p.type = ElementType::Float32;
  return p;
}

Preparation of_gray(uint32_t width, uint32_t height, uint32_t to_width, uint32_t to_height) {
  return preparation(Pixels("GRAY8", width, height).picture, to_width, to_height);
}

constexpr Rect kHundred{0, 0, 100, 100};

TEST(RegionPlacement, ShowsTheTargetPixelsWhoseMiddleIsInThePicture) {
  // Target pixel t covers 2t - 10 to 2t - 8; the first one with its centre at or after 0 is 5.
  const auto left = place(of_gray(100, 100, 20, 20), kHundred, {-10, 5, 40, 40});
  EXPECT_EQ(left.source, (Rect{0, 5, 30, 40}));
  EXPECT_EQ(left.content, (Rect{5, 0, 15, 20}));
  // Starts at 4t + 90: three target pixels have the centres 92, 96 and 100, which is outside.
  const auto right = place(of_gray(100, 100, 10, 10), kHundred, {90, 70, 40, 40});
  EXPECT_EQ(right.source, (Rect{90, 70, 10, 30}));
  EXPECT_EQ(right.content, (Rect{0, 0, 2, 7}));
  const auto around = place(of_gray(100, 100, 30, 30), kHundred, {-100, -100, 300, 300});
  EXPECT_EQ(around.source, kHundred);
  EXPECT_EQ(around.content, (Rect{10, 10, 10, 10}));
}

TEST(RegionPlacement, WithinThePictureEqualsACrop) {
  auto p = of_gray(100, 100, 7, 9);
  for (const Fit fit : {Fit::Stretch, Fit::Letterbox, Fit::CentreCrop}) {
    p.fit = fit;
    p.crop = Rect{13, 20, 51, 80};
    p.region.reset();
    const auto wanted = place(p);
    const auto placed = place(p, kHundred, {13, 20, 51, 80});
    EXPECT_EQ(placed.source, wanted.source);
    EXPECT_EQ(placed.content, wanted.content);
  }
}

TEST(RegionPlacement, LetterboxesTheWholeRegionNotItsVisiblePart) {
  auto p = of_gray(100, 100, 10, 10);
  p.fit = Fit::Letterbox;  // 40x20 becomes 10x5, below two rows of padding
  EXPECT_EQ(place(p, kHundred, {-20, 0, 40, 20}).content, (Rect{5, 2, 5, 5}));
  p.fit = Fit::CentreCrop;  // the centred 20x20 of 40x20 begins at -10
  EXPECT_EQ(place(p, kHundred, {-20, 0, 40, 20}).content, (Rect{5, 0, 5, 10}));
}

TEST(RegionPlacement, MapsBackToTheRegionOutsideThePicture) {
  auto p = of_gray(100, 100, 20, 10);
  for (const Roi& box : {Roi{-10, 5, 40, 40}, Roi{80, -30, 60, 50}, Roi{3, 4, 5, 6}}) {
    p.region = box;
    const auto map = make_source_map(p);
    const Point begin = map.to_source({0, 0}), end = map.to_source({20, 10});
    EXPECT_DOUBLE_EQ(begin.x, static_cast<double>(box.x));
    EXPECT_DOUBLE_EQ(begin.y, static_cast<double>(box.y));
    EXPECT_DOUBLE_EQ(end.x, static_cast<double>(box.x + box.width));
    EXPECT_DOUBLE_EQ(end.y, static_cast<double>(box.y + box.height));
  }
}

TEST(RegionPlacement, OutsideThePictureIsAnError) {
  const auto p = of_gray(100, 100, 10, 10);
  constexpr int64_t kFar = int64_t{1} << 62;
  for (const Roi& box :
       {Roi{100, 0, 10, 10}, Roi{-10, 0, 10, 10}, Roi{0, 100, 10, 10}, Roi{0, 0, 0, 5},
        Roi{0, 0, 5, -1}, Roi{-39, 0, 40, 40}, Roi{kFar, 0, 10, 10}, Roi{-kFar, 0, 10, 10},
        Roi{0, 0, kFar, 10}, Roi{-kFar, -kFar, kFar, kFar}}) {
    EXPECT_EQ(place(p, kHundred, box).content.width, 0u) << box.x << " " << box.width;
    const Status status = check_region(p, kHundred, box);
    ASSERT_FALSE(status);
    EXPECT_EQ(status.error().code, Code::OPTION_VALUE);
    EXPECT_SAYS(status.error().message(), "the region lies outside the picture");
    EXPECT_SAYS(status.error().message(), "100x100 at 0,0");
  }
  EXPECT_TRUE(check_region(p, kHundred, {-38, 0, 40, 40})) << "a middle is at 0";
  auto own = p;
  own.region = Roi{200, 200, 5, 5};
  EXPECT_FALSE(PreprocessPlan::make(own));
}

TEST(RegionPlan, AgreesWithTheFormulas) {
  std::mt19937 random(5);
  const auto below = [&](uint32_t bound) { return static_cast<uint32_t>(random() % bound); };
  int outside = 0;
  for (int i = 0; i < 400; ++i) {
    constexpr const char* kFormats[] = {"RGB",  "BGRx", "GRAY8", "NV12", "NV21",
                                        "I420", "YV12", "YUY2",  "UYVY"};
    const Pixels pixels(kFormats[below(5)], 1 + below(40), 1 + below(40), random(), below(5));
    auto p = preparation(pixels.picture, 1 + below(50), 1 + below(30));
    p.source.range = static_cast<ColorRange>(below(2));
    p.source.cosited_columns = below(2);
    p.source.cosited_rows = below(2);
    p.resize = static_cast<Resize>(below(3));
    p.fit = static_cast<Fit>(below(3));
    p.layout = static_cast<Layout>(below(2));
    p.padding = below(256);
    const auto side = [&] { return static_cast<int64_t>(below(80)) - 40; };
    p.region = Roi{side(), side(), 1 + below(90), 1 + below(90)};
    const Rect all{0, 0, p.source.width, p.source.height};
    if (!check_region(p, all, *p.region)) continue;
    outside += place(p).content != Rect{0, 0, p.width, p.height};
    SCOPED_TRACE(i);
    const auto got = run<float>(p, pixels);
    const auto wanted = reference(p, pixels);
    ASSERT_EQ(got.size(), wanted.size());
    for (size_t k = 0; k < got.size(); ++k) ASSERT_NEAR(double{got[k]}, wanted[k], 1.0 / 16) << k;
  }
  EXPECT_GT(outside, 100);
}

// Compares with the picture on a canvas of padding, where the region is an ordinary crop: pixels
// made only of inner pixels are equal, and so are pixels made only of padding.
TEST(RegionPlan, EqualsAPictureOnACanvas) {
  constexpr uint32_t kSide = 40, kEdge = 30, kCanvas = kSide + 2 * kEdge;
  const Pixels pixels("GRAY8", kSide, kSide, 3);
  Pixels canvas("GRAY8", kCanvas, kCanvas);
  std::memset(canvas.memory.data(), 9, canvas.memory.size());
  for (uint32_t y = 0; y < kSide; ++y)
    std::memcpy(canvas.memory.data() + (y + kEdge) * kCanvas + kEdge,
                pixels.memory.data() + y * kSide, kSide);
  for (const Roi& box : {Roi{-20, 10, 48, 24}, Roi{25, -12, 32, 32}, Roi{-30, -30, 100, 100}}) {
    auto p = preparation(pixels.picture, 24, 16), q = preparation(canvas.picture, 24, 16);
    p.padding = 9;
    p.region = box;
    q.crop = Rect{static_cast<uint32_t>(box.x + kEdge), static_cast<uint32_t>(box.y + kEdge),
                  static_cast<uint32_t>(box.width), static_cast<uint32_t>(box.height)};
    const auto got = run<float>(p, pixels), wanted = run<float>(q, canvas);
    ASSERT_EQ(got.size(), wanted.size());
    int compared = 0;
    for (uint32_t y = 0; y < 16; ++y)
      for (uint32_t x = 0; x < 24; ++x) {
        // At the edge, the canvas mixes pixels from inside and outside.
        const auto on_edge = [](double at) {
          return std::abs(at) < 0.5 || std::abs(at - kSide) < 0.5;
        };
        const double across =
            static_cast<double>(box.x) + (x + 0.5) * static_cast<double>(box.width) / 24;
        const double down =
            static_cast<double>(box.y) + (y + 0.5) * static_cast<double>(box.height) / 16;
        if (on_edge(across) || on_edge(down)) continue;
        const size_t at = (size_t{y} * 24 + x) * 3;
        ASSERT_NEAR(got[at], wanted[at], 1.0 / 32) << x << " " << y;
        ++compared;
      }
    EXPECT_GT(compared, 250);
  }
}

TEST(RegionPlan, FramesAreIndependent) {
  const Pixels pixels("NV12", 61, 47, 5, 3);
  const Rect all{0, 0, 61, 47};
  auto p = preparation(pixels.picture, 20, 12);
  p.padding = 77;
  auto plan = PreprocessPlan::make(p);
  Workspace workspace;
  std::mt19937 random(11);
  const auto side = [&] { return static_cast<int64_t>(random() % 100) - 50; };
  for (int i = 0; i < 60; ++i) {
    const Roi box{side(), side(), 51 + side(), 51 + side()};
    auto fresh = p;
    if (i % 3 == 0) {
      fresh.crop = Rect{3, 4, 5u + static_cast<uint32_t>(i % 50), 30};
      ASSERT_TRUE(plan->set_crop(*fresh.crop));
    } else {
      if (!check_region(p, all, box)) {
        EXPECT_FALSE(plan->set_region(all, box));
        continue;
      }
      fresh.region = box;
      ASSERT_TRUE(plan->set_region(all, box));
    }
    plan->grow(&workspace);
    std::vector<float> out(size_t{20} * 12 * 3, -1.0f);
    ASSERT_TRUE(plan->run(pixels.planes, std::as_writable_bytes(std::span(out)), &workspace));
    ASSERT_EQ(out, run<float>(fresh, pixels)) << i;
  }
  EXPECT_FALSE(plan->set_region({0, 0, 62, 47}, {0, 0, 5, 5})) << "more than the picture";
}

}  // namespace plan_regions_test
}  // namespace weir::preprocess
