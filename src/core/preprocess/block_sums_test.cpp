// Sums of blocks against plain loops, and plans that are made of them against the formulas.
#include "core/preprocess/block_sums.hpp"

#include <gtest/gtest.h>

#include <string>

#include "core/preprocess/plan_reference.hpp"
#include "core/preprocess/row_kernels.hpp"
#include "core/preprocess/runner.hpp"
#include "core/transform/transform_test_support.hpp"

namespace weir::preprocess {
namespace {

using testing::Pixels;
using transform::test::for_each_target;

TEST(BlockSums, AddsNeighbouringSamplesLaneByLane) {
  std::mt19937 random(3);
  for (const size_t step : {1u, 2u, 3u, 4u})
    for (const size_t blocks : {0u, 1u, 2u, 15u, 31u, 64u, 133u}) {
      std::vector<uint8_t> bytes(2 * blocks * step);
      std::vector<uint16_t> numbers(bytes.size());
      for (auto& byte : bytes) byte = static_cast<uint8_t>(random());
      for (auto& number : numbers) number = static_cast<uint16_t>(random() % 0x8000);
      for_each_target([&] {
        std::vector<uint16_t> of_bytes(blocks * step + 1, 7), of_numbers(blocks * step + 1, 7);
        add_byte_pairs(bytes.data(), step, blocks, of_bytes.data());
        add_pairs(numbers.data(), step, blocks, of_numbers.data());
        for (size_t b = 0; b < blocks; ++b)
          for (size_t l = 0; l < step; ++l) {
            const size_t i = 2 * b * step + l;
            ASSERT_EQ(of_bytes[b * step + l], bytes[i] + bytes[i + step]) << step << " " << b;
            ASSERT_EQ(of_numbers[b * step + l], numbers[i] + numbers[i + step]) << step << " " << b;
          }
        EXPECT_EQ(of_bytes.back(), 7);
        EXPECT_EQ(of_numbers.back(), 7);
      });
    }
}

TEST(BlockSums, AreOfWholeBlocksAndMadeAsTheyAreWanted) {
  constexpr size_t kRows = 9, kStep = 2, kSamples = 300;
  std::vector<uint8_t> plane(kRows * kSamples * kStep);
  std::mt19937 random(4);
  for (auto& byte : plane) byte = static_cast<uint8_t>(random());
  const ptrdiff_t upwards = -static_cast<ptrdiff_t>(kSamples * kStep);
  for (const auto& [low, high] : {std::pair<size_t, size_t>{0, 256}, {4, 300}, {128, 192}}) {
    BlockSums sums(0, low, high, kStep);
    sums.want(3, 5, 4);
    sums.want(2, 8, 64);
    sums.reserve();
    const uint8_t* last = plane.data() + (kRows - 1) * kSamples * kStep;
    for (const size_t end : {4u, 3u, 8u}) sums.make(last, upwards, end);
    for (size_t row = 2; row < 8; ++row)
      for (size_t block = kLeastBlock; block <= kMostBlock; block *= 2)
        for (size_t b = (low + block - 1) / block, n = 0; b < high / block; ++b, ++n)
          for (size_t l = 0; l < kStep; ++l) {
            int sum = 0;
            for (size_t i = 0; i < block; ++i)
              sum += plane[((kRows - 1 - row) * kSamples + b * block + i) * kStep + l];
            ASSERT_EQ(sums.row(row, block)[n * kStep + l], sum) << row << " " << block << " " << b;
          }
  }
}

Preparation of_area(const Pixels& pixels, uint32_t width, uint32_t height) {
  Preparation p;
  p.source = pixels.picture;
  p.width = width;
  p.height = height;
  p.type = ElementType::Float32;
  p.resize = Resize::Area;
  return p;
}

TEST(PlanOfBlocks, GivesWhatTheFormulasSay) {
  for (const char* format : {"GRAY8", "RGB", "NV12"}) {
    Pixels pixels(format, 384, 21, 5, 3);
    const double most = pixels.picture.format.model == ColorModel::Yuv ? 1.0 / 16 : 1.0 / 64;
    for (const uint32_t width : {48u, 2u})
      for (const bool second : {false, true}) {
        pixels.picture.cosited_columns = second;
        auto p = of_area(pixels, width, 8);
        if (second) p.crop = Rect{96, 3, 288, 17};
        const auto wanted = testing::reference(p, pixels);
        for_each_target([&] {
          const auto out = testing::run<float>(p, pixels);
          ASSERT_EQ(out.size(), wanted.size());
          for (size_t i = 0; i < out.size(); ++i)
            ASSERT_NEAR(double{out[i]}, wanted[i], most)
                << format << " to " << width << ", element " << i;
        });
      }
  }
}

// Big enough for several stripes; layers of whole blocks and others, letterboxed ones too.
TEST(PlanOfBlocks, LayersOfAPyramidAreThoseOfPlansAlone) {
  for (const uint32_t seed : {1u, 2u}) {
    const Pixels pixels("NV12", 1024, 1100, seed);
    for (const Fit fit : {Fit::Stretch, Fit::Letterbox}) {
      std::vector<Plan> plans;
      std::vector<std::vector<float>> wanted;
      for (const auto& [width, height] :
           {std::pair{512u, 275u}, {256u, 275u}, {100u, 77u}, {64u, 68u}, {3u, 5u}, {1u, 1u}}) {
        auto p = of_area(pixels, width, height);
        p.fit = fit;
        plans.push_back(*Plan::make(p));
        wanted.push_back(testing::run<float>(p, pixels));
      }
      for (const size_t threads : {1u, 3u}) {
        Runner runner(threads);
        const Pixels other("NV12", 1024, 1100, seed + 7);
        for (const Pixels* frame : {&other, &pixels}) {
          std::vector<std::vector<float>> out;
          for (const auto& one : wanted) out.emplace_back(one.size());
          std::vector<Job> jobs;
          for (size_t i = 0; i < plans.size(); ++i)
            jobs.push_back({&plans[i], std::as_writable_bytes(std::span(out[i]))});
          ASSERT_TRUE(runner.run(frame->planes, jobs));
          if (frame == &pixels)
            EXPECT_EQ(out, wanted) << threads << " threads";
          else
            EXPECT_NE(out, wanted) << "a frame's sums are its own";
        }
      }
    }
  }
}

}  // namespace
}  // namespace weir::preprocess
