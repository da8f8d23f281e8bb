// Compares plans with the plain formulas and checks which preparations are rejected.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/preprocess/plan.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "core/preprocess/plan_reference_test_support.hpp"
#include "core/transform/transform_test_support.hpp"
#include "says.hpp"

namespace weir::preprocess {
namespace plan_test {

using testing::Pixels;
using testing::reference;
using testing::run;
using transform::test::for_each_target;

Preparation preparation(const Pixels& pixels, uint32_t width, uint32_t height,
                        ElementType type = ElementType::Float32) {
  Preparation p;
  p.source = pixels.picture;
  p.width = width;
  p.height = height;
  p.type = type;
  return p;
}

void expect_near(const std::vector<float>& got, const std::vector<double>& wanted, double max) {
  ASSERT_EQ(got.size(), wanted.size());
  for (size_t i = 0; i < got.size(); ++i)
    ASSERT_NEAR(double{got[i]}, wanted[i], max) << "element " << i;
}

// The accuracy that preparation.hpp promises, in steps of 255.
double max_error(const Preparation& p) {
  if (p.resize == Resize::Nearest) return 0.001;
  return 1.0 / 256;
}

constexpr const char* kFormats[] = {"RGB",  "BGR",  "RGBx", "BGRx", "xRGB",  "xBGR",
                                    "RGBA", "BGRA", "ARGB", "ABGR", "GRAY8", "NV12",
                                    "NV21", "I420", "YV12", "YUY2", "UYVY"};
constexpr Resize kResizes[] = {Resize::Nearest, Resize::Bilinear, Resize::Area};

TEST(PreprocessPlan, ResizesEachFormatLikeTheFormulas) {
  for (const char* format : kFormats)
    for (const Resize resize : kResizes) {
      SCOPED_TRACE(std::string(format) + " " + std::to_string(static_cast<int>(resize)));
      const Pixels pixels(format, 29, 17, 5, 3);
      for (const auto& [width, height] : {std::pair{11u, 7u}, {29u, 17u}, {45u, 20u}, {60u, 5u}}) {
        auto p = preparation(pixels, width, height);
        p.resize = resize;
        expect_near(run<float>(p, pixels), reference(p, pixels), max_error(p));
      }
    }
}

TEST(PreprocessPlan, AppliesANewCropLikeANewPlan) {
  std::mt19937 random(11);
  const auto below = [&](uint32_t bound) { return static_cast<uint32_t>(random() % bound); };
  for (const char* format :
       {"RGB", "RGBx", "GRAY8", "NV12", "NV21", "I420", "YV12", "YUY2", "UYVY"})
    for (const Resize resize : kResizes)
      for (const Fit fit : {Fit::Stretch, Fit::Letterbox, Fit::CentreCrop}) {
        const Pixels pixels(format, 61, 47, 5, 3);
        auto p = preparation(pixels, 40, 12);
        p.resize = resize;
        p.fit = fit;
        auto plan = PreprocessPlan::make(p);
        const PreprocessPlan before =
            *plan;  // shares the tables until set_crop() and must keep them
        Workspace workspace;
        for (int i = 0; i < 20; ++i) {
          const uint32_t x = below(61), y = below(47);
          p.crop = Rect{x, y, 1 + below(61 - x), 1 + below(47 - y)};
          ASSERT_TRUE(plan->set_crop(*p.crop));
          plan->grow(&workspace);
          std::vector<float> out(size_t{40} * 12 * 3);
          const auto bytes = std::as_writable_bytes(std::span(out));
          ASSERT_TRUE(plan->run(pixels.planes, bytes, &workspace));
          ASSERT_EQ(out, run<float>(p, pixels)) << format << " " << i;
        }
        EXPECT_FALSE(plan->set_crop({60, 0, 2, 1}));
        EXPECT_FALSE(plan->set_crop({0, 0, 0, 1}));
        EXPECT_EQ(plan->preparation().crop, p.crop);
        EXPECT_FALSE(before.preparation().crop);
      }
}

TEST(PreprocessPlan, ResizesAnyPartLikeTheFormulas) {
  std::mt19937 random(7);
  const auto below = [&](uint32_t bound) { return static_cast<uint32_t>(random() % bound); };
  for (int i = 0; i < 200; ++i) {
    SCOPED_TRACE(i);
    const Pixels pixels(kFormats[below(13)], 1 + below(40), 1 + below(40), random(), below(5));
    auto p = preparation(pixels, 1 + below(70), 1 + below(40));
    p.source.matrix = static_cast<ColorMatrix>(below(3));
    p.source.range = static_cast<ColorRange>(below(2));
    p.source.cosited_columns = below(2);
    p.source.cosited_rows = below(2);
    p.resize = kResizes[below(3)];
    p.fit = static_cast<Fit>(below(3));
    p.order = static_cast<ChannelOrder>(below(3));
    p.layout = static_cast<Layout>(below(2));
    p.padding = below(256);
    const Rect part{below(p.source.width), below(p.source.height), 0, 0};
    p.crop = Rect{part.x, part.y, 1 + below(p.source.width - part.x),
                  1 + below(p.source.height - part.y)};
    const auto numbers = reference(p, pixels);
    for_each_target([&] { expect_near(run<float>(p, pixels), numbers, max_error(p)); });
  }
}

// Luma of four samples and chroma of two, and rows longer than a vector.
TEST(PreprocessPlan, MixesComponentsOfDifferentGrids) {
  for (const char* format : {"NV12", "NV21", "I420", "YV12", "YUY2", "UYVY"}) {
    const Pixels pixels(format, 40, 32, 5, 3);
    auto p = preparation(pixels, 8, 8);
    p.resize = Resize::Area;
    p.crop = Rect{2, 0, 32, 32};
    for_each_target(
        [&] { expect_near(run<float>(p, pixels), reference(p, pixels), max_error(p)); });
  }
  for (const char* format : {"GRAY8", "RGBx", "NV12"}) {
    const Pixels pixels(format, 230, 9, 5, 3);
    const auto p = preparation(pixels, 70, 4);
    for_each_target(
        [&] { expect_near(run<float>(p, pixels), reference(p, pixels), max_error(p)); });
  }
}

TEST(PreprocessPlan, KeepsPixelsOfTheSameSize) {
  const Pixels pixels("BGRx", 45, 9, 3);
  for (const Resize resize : kResizes) {
    auto p = preparation(pixels, 45, 9, ElementType::UInt8);
    p.resize = resize;
    for_each_target([&] {
      const auto out = run<uint8_t>(p, pixels);
      ASSERT_EQ(out.size(), 3u * 45 * 9);
      for (size_t i = 0; i < size_t{45} * 9; ++i)
        for (size_t c = 0; c < 3; ++c)
          ASSERT_EQ(out[3 * i + c], std::to_integer<uint8_t>(pixels.memory[4 * i + 2 - c]));
    });
  }
}

TEST(PreprocessPlan, ComputesNumbersAsFloatsDo) {
  const Pixels pixels("RGB", 33, 4);
  auto p = preparation(pixels, 33, 4);
  p.layout = Layout::Nchw;
  p.mean = {123.675, 116.28, 103.53};
  p.scale = {0.0171247538, 0.0175070028, 0.0174291939};
  const auto out = run<float>(p, pixels);
  ASSERT_EQ(out.size(), 3u * 33 * 4);
  for (size_t i = 0; i < out.size(); ++i) {
    const size_t c = i / (33 * 4), at = i % (33 * 4) * 3 + c;
    const auto pixel = static_cast<float>(std::to_integer<int>(pixels.memory[at]));
    ASSERT_EQ(out[i], (pixel - static_cast<float>(p.mean[c])) * static_cast<float>(p.scale[c]));
  }
}

TEST(PreprocessPlan, AveragesBlocks) {
  const Pixels pixels("GRAY8", 8, 4);
  auto p = preparation(pixels, 4, 2);
  p.order = ChannelOrder::Gray;
  p.resize = Resize::Area;
  const auto out = run<float>(p, pixels);
  ASSERT_EQ(out.size(), 8u);
  for (size_t i = 0; i < 8; ++i) {
    int sum = 0;
    for (size_t j = 0; j < 4; ++j)
      sum += std::to_integer<int>(pixels.memory[(i / 4 * 2 + j / 2) * 8 + i % 4 * 2 + j % 2]);
    EXPECT_FLOAT_EQ(out[i], static_cast<float>(sum) / 4);
  }
}

TEST(PreprocessPlan, WritesEachElementType) {
  const Pixels pixels("RGB", 40, 6, 2);
  auto p = preparation(pixels, 21, 9);
  p.mean = {127.5};
  p.scale = {0.5};
  const auto numbers = reference(p, pixels);
  for_each_target([&] {
    p.type = ElementType::Int8;
    const auto bytes = run<int8_t>(p, pixels);
    p.type = ElementType::Float16;
    const auto halves = run<float16>(p, pixels);
    ASSERT_EQ(bytes.size(), numbers.size());
    ASSERT_EQ(halves.size(), numbers.size());
    for (size_t i = 0; i < numbers.size(); ++i) {
      ASSERT_NEAR(bytes[i], numbers[i], 0.501);
      ASSERT_NEAR(float{halves[i]}, numbers[i], 0.05);
    }
  });
}

TEST(PreprocessPlan, QuantisesAndSaturates) {
  const Pixels pixels("RGB", 16, 16);
  auto p = preparation(pixels, 16, 16, ElementType::Int8);
  p.mean = {127.5};
  p.scale = {1 / 127.5};
  const auto numbers = reference(p, pixels);
  p.quantisation = Quantisation{0.005, -20};
  const auto out = run<int8_t>(p, pixels);
  ASSERT_EQ(out.size(), numbers.size());
  for (size_t i = 0; i < out.size(); ++i)
    ASSERT_NEAR(out[i], std::clamp(numbers[i] / 0.005 - 20, -128.0, 127.0), 0.501);
  EXPECT_EQ(*std::max_element(out.begin(), out.end()), 127);
  EXPECT_EQ(*std::min_element(out.begin(), out.end()), -128);
}

TEST(PreprocessPlan, PadsWithThePixelValueInEachLayout) {
  const Pixels pixels("RGB", 20, 10);
  for (const Layout layout : {Layout::Nhwc, Layout::Nchw}) {
    auto p = preparation(pixels, 16, 16);
    p.fit = Fit::Letterbox;
    p.padding = 114;
    p.layout = layout;
    p.mean = {0, 14, 114};
    p.scale = {1, 2, 3};
    const auto out = run<float>(p, pixels);
    expect_near(out, reference(p, pixels), 0.05);
    ASSERT_FALSE(out.empty());
    EXPECT_EQ(out[0], 114.0f);
    EXPECT_EQ(out[layout == Layout::Nhwc ? 1 : 256], 200.0f);
    EXPECT_EQ(out.back(), 0.0f);
  }
}

TEST(PreprocessPlan, ReadsRowsUpsideDown) {
  Pixels pixels("GRAY8", 5, 3);
  auto p = preparation(pixels, 5, 3, ElementType::UInt8);
  p.order = ChannelOrder::Gray;
  const auto upright = run<uint8_t>(p, pixels);
  pixels.planes[0].offset = 10;
  pixels.planes[0].stride = -5;
  const auto flipped = run<uint8_t>(p, pixels);
  ASSERT_EQ(flipped.size(), 15u);
  for (size_t i = 0; i < 15; ++i) EXPECT_EQ(flipped[i], upright[(2 - i / 5) * 5 + i % 5]);
}

TEST(PreprocessPlan, RunsTheRequestedRows) {
  const Pixels pixels("I420", 30, 20);
  auto p = preparation(pixels, 13, 12, ElementType::UInt8);
  p.fit = Fit::Letterbox;
  const auto whole = run<uint8_t>(p, pixels);
  const auto plan = PreprocessPlan::make(p);
  std::vector<uint8_t> out(whole.size(), 77);
  auto workspace = plan->workspace();
  const auto bytes = std::as_writable_bytes(std::span(out));
  ASSERT_TRUE(plan->run_rows(pixels.planes, bytes, 5, 4, &workspace));
  EXPECT_EQ(out[5 * 39 - 1], 77);
  EXPECT_EQ(out[9 * 39], 77);
  ASSERT_TRUE(plan->run_rows(pixels.planes, bytes, 0, 5, &workspace));
  ASSERT_TRUE(plan->run_rows(pixels.planes, bytes, 9, 100, &workspace));
  EXPECT_EQ(out, whole);
}

// Rows start and end anywhere within a vector; nothing but the tensor is written.
TEST(PreprocessPlan, WritesTheSameNumbersWithStreamingStores) {
  for (const uint32_t width : {1u, 3u, 15u, 16u, 33u, 64u, 127u})
    for (const Layout layout : {Layout::Nchw, Layout::Nhwc})
      for (const size_t shift : {size_t{0}, size_t{4}, size_t{5}}) {
        const Pixels pixels("NV12", 50, 40);
        auto p = preparation(pixels, width, 7);
        p.layout = layout;
        p.fit = shift == 4 ? Fit::Letterbox : Fit::Stretch;
        const auto plan = PreprocessPlan::make(p);
        ASSERT_TRUE(plan);
        auto workspace = plan->workspace();
        const size_t bytes = *p.tensor().bytes();
        std::vector<std::byte> cached(bytes), streamed(bytes + 16, std::byte{0xEE});
        const auto out = std::span(streamed).subspan(shift, bytes);
        for_each_target([&] {
          std::fill(streamed.begin(), streamed.end(), std::byte{0xEE});
          ASSERT_TRUE(plan->run(pixels.planes, cached, &workspace));
          ASSERT_TRUE(plan->run_rows(pixels.planes, out, 0, 7, &workspace, {.streamed = true}));
          EXPECT_TRUE(std::equal(cached.begin(), cached.end(), out.begin())) << width;
          const auto beyond = std::count(streamed.begin(), streamed.end(), std::byte{0xEE}) -
                              std::count(out.begin(), out.end(), std::byte{0xEE});
          EXPECT_EQ(beyond, 16) << width;
        });
      }
}

TEST(PreprocessPlan, RejectsMemoryThatIsTooShort) {
  for (const char* format : {"RGB", "NV12", "NV21", "I420", "YV12", "YUY2", "UYVY"}) {
    Pixels pixels(format, 30, 20);
    const auto plan = PreprocessPlan::make(preparation(pixels, 8, 8));
    auto workspace = plan->workspace();
    std::vector<std::byte> out(8 * 8 * 3 * 4);
    EXPECT_TRUE(plan->run(pixels.planes, out, &workspace));
    auto planes = pixels.planes;
    for (auto& plane : planes)
      if (!plane.memory.empty()) plane.memory = plane.memory.first(pixels.memory.size() - 1);
    const auto status = plan->run(planes, out, &workspace);
    ASSERT_FALSE(status) << format;
    EXPECT_EQ(status.error().code, Code::FRAME_SIZE);
    EXPECT_SAYS(status.error().message(), "shorter than its size requires");
    planes = pixels.planes;
    planes[0].stride = -1;
    EXPECT_FALSE(plan->run(planes, out, &workspace));
    planes[0].stride = std::numeric_limits<ptrdiff_t>::max();
    EXPECT_FALSE(plan->run(planes, out, &workspace));
    planes[0] = {pixels.memory, std::numeric_limits<size_t>::max(), 1};
    EXPECT_FALSE(plan->run(planes, out, &workspace));
    const auto small = plan->run(pixels.planes, std::span(out).first(9), &workspace);
    ASSERT_FALSE(small);
    EXPECT_SAYS(small.error().message(), "needed: 768 bytes");
  }
}

struct Refused {
  const char* words;
  void (*spoil)(Preparation*);
};

TEST(PreprocessPlan, RejectsImpossibleRequests) {
  const Refused cases[] = {
      {"size of the tensor is unknown", [](auto* p) { p->width = 0; }},
      {"the tensor is too large", [](auto* p) { p->height = 65537; }},
      {"the picture is empty or too large", [](auto* p) { p->source.height = 0; }},
      {"the picture is empty or too large", [](auto* p) { p->source.width = 1u << 20; }},
      {"offered: int32", [](auto* p) { p->type = ElementType::Int32; }},
      {"0 to 255", [](auto* p) { p->padding = 256; }},
      {"0 to 255", [](auto* p) { p->padding = std::nan(""); }},
      {"mean of 2 numbers",
       [](auto* p) {
         p->mean = {1, 2};
       }},
      {"scale of 3 numbers",
       [](auto* p) {
         p->order = ChannelOrder::Gray;
         p->scale = {1, 2, 3};
       }},
      {"beyond the range of float32", [](auto* p) { p->mean = {1e39}; }},
      {"beyond the range of float32", [](auto* p) { p->scale = {std::nan("")}; }},
      {"only integer types can be quantised",
       [](auto* p) {
         p->quantisation = Quantisation{1, 0};
       }},
      {"scale of the quantisation",
       [](auto* p) {
         p->type = ElementType::UInt8;
         p->quantisation = Quantisation{0, 0};
       }},
      {"offered: -1 of uint8",
       [](auto* p) {
         p->type = ElementType::UInt8;
         p->quantisation = Quantisation{1, -1};
       }},
      {"the crop exceeds the picture",
       [](auto* p) {
         p->crop = Rect{1, 0, 20, 20};
       }},
      {"the crop exceeds the picture",
       [](auto* p) {
         p->crop = Rect{0, 0, 20, 0};
       }},
      {"the crop exceeds the picture",
       [](auto* p) {
         p->crop = Rect{4294967295u, 0, 2, 2};
       }},
      {"NV12", [](auto* p) { p->source.format.name = "nv12"; }},
  };
  const Pixels pixels("RGB", 20, 20);
  for (const auto& [words, spoil] : cases) {
    auto p = preparation(pixels, 8, 8);
    spoil(&p);
    const auto plan = PreprocessPlan::make(p);
    ASSERT_FALSE(plan) << words;
    EXPECT_SAYS(plan.error().message(), words);
  }
}

}  // namespace plan_test
}  // namespace weir::preprocess
