// Sums of blocks against plain loops, and plans that are made of them against the formulas.
#include "core/preprocess/block_sums.hpp"

#include <gtest/gtest.h>

#include <random>
#include <string>

#include "core/preprocess/plan_reference.hpp"
#include "core/preprocess/row_kernels.hpp"
#include "core/preprocess/runner.hpp"
#include "core/transform/transform_test_support.hpp"

namespace weir::preprocess {
namespace {

using testing::Pixels;
using transform::test::for_each_target;

constexpr size_t kAlone = 13;  // a row that is asked for by itself

// Of the rows [first, end), each `together` of them may be added up, in blocks of `block` samples.
struct Wanted {
  size_t first, end, block, together;
};

// Rows of random bytes, the last one first in memory.
struct Upwards {
  static constexpr size_t kRows = 19, kSamples = 700;
  explicit Upwards(size_t samples_step) : step(samples_step), bytes(kRows * kSamples * step) {
    std::mt19937 random(4);
    for (auto& byte : bytes) byte = static_cast<uint8_t>(random());
    std::fill_n(bytes.begin(), 3 * kSamples * step, uint8_t{255});  // the largest sums
  }
  const uint8_t* memory() const { return bytes.data() + (kRows - 1) * kSamples * step; }
  ptrdiff_t stride() const { return -static_cast<ptrdiff_t>(kSamples * step); }
  int sum(size_t row, size_t rows, size_t sample, size_t samples, size_t lane) const {
    int out = 0;
    for (size_t r = row; r < row + rows; ++r)
      for (size_t i = sample; i < sample + samples; ++i) out += at(r, i, lane);
    return out;
  }
  // Four times the sum from a quarter of a sample on to a quarter behind the last one, if there is
  // one.
  int shifted_sum(size_t row, size_t rows, size_t sample, size_t samples, size_t lane,
                  bool one_more) const {
    int out = 4 * sum(row, rows, sample, samples, lane) - sum(row, rows, sample, 1, lane);
    return one_more ? out + sum(row, rows, sample + samples, 1, lane) : out;
  }
  int at(size_t row, size_t sample, size_t lane) const {
    return bytes[((kRows - 1 - row) * kSamples + sample) * step + lane];
  }
  size_t step;
  std::vector<uint8_t> bytes;
};

void expect_sums(const BlockSums& sums, const Upwards& plane, const Wanted& wanted) {
  const size_t block = wanted.block, low = sums.of().low, high = sums.of().high;
  for (size_t row = wanted.first, together = 0; row < wanted.end; row += together) {
    together = 1;  // what one row of sums is of
    while (row + together < wanted.end && sums.sums_of(row, together + 1, block) == 1) ++together;
    ASSERT_LE(together, sums.most_rows_of(block));
    const bool alone = row <= kAlone && kAlone < row + together;
    if (wanted.together > 1) {
      ASSERT_EQ(together, wanted.together);
    } else if (alone) {
      ASSERT_EQ(together, 1u);
    }
    for (size_t b = (low + block - 1) / block, n = 0; b < high / block; ++b, ++n)
      for (size_t l = 0; l < plane.step; ++l)
        ASSERT_EQ(sums.row(row, block)[n * plane.step + l],
                  sums.of().cosited ? plane.shifted_sum(row, together, b * block, block, l,
                                                        (b + 1) * block < high)
                                    : plane.sum(row, together, b * block, block, l))
            << "row " << row << ", block " << b << " of " << block << ", step " << plane.step;
  }
}

void expect_sums_as_wanted(bool cosited, const std::vector<std::vector<Wanted>>& all) {
  for (const size_t step : {1u, 2u, 3u, 4u}) {
    const Upwards plane(step);
    for (const auto& [low, high] :
         {std::pair<size_t, size_t>{0, 256}, {4, 700}, {128, 192}, {64, 640}})
      for (const auto& wanted : all)
        for_each_target([&] {
          BlockSums sums({0, low, high, step, cosited});
          for (const Wanted& w : wanted) {
            sums.want(w.first, w.end, w.block, w.together);
            if (w.together > 1) continue;
            for (const size_t row : {w.first, kAlone, w.end - 1}) {
              sums.want_begin(row);
              sums.want_begin(row + 1);
            }
          }
          sums.reserve();
          for (const size_t end : {6u, 3u, 7u, 18u}) sums.make(plane.memory(), plane.stride(), end);
          for (const Wanted& w : wanted) expect_sums(sums, plane, w);
        });
  }
}

TEST(BlockSums, AreOfWholeBlocksAndMadeAsTheyAreWanted) {
  expect_sums_as_wanted(
      false, {{{3, 5, 4, 1}, {2, 18, 64, 1}},
              {{8, 16, 4, 4}, {5, 18, 16, 1}, {2, 17, 2, 1}},
              {{0, 16, 4, 16}, {8, 16, 8, 8}, {16, 18, 32, 2}},
              {{0, 18, 64, 1}, {8, 16, 8, 8}, {0, 16, 2, 16}},
              {{4, 8, 64, 4}, {1, 18, 32, 1}, {1, 17, 8, 1}, {1, 17, 4, 1}, {1, 17, 16, 1}}});
}

TEST(BlockSums, OfCositedSamplesAreAQuarterFurtherRight) {
  expect_sums_as_wanted(true, {{{3, 5, 2, 1}, {2, 18, 16, 1}},
                               {{8, 16, 4, 4}, {5, 18, 16, 1}},
                               {{0, 16, 2, 16}, {8, 16, 4, 8}, {16, 18, 8, 2}},
                               {{4, 8, 16, 4}, {1, 18, 8, 1}, {1, 17, 4, 1}, {1, 17, 2, 1}}});
}

TEST(BlockSums, AreOfUpToFourRowsThatBeginWhereTheyShall) {
  const Upwards plane(1);
  BlockSums sums({0, 0, 256, 1});
  sums.want(1, 19, 64, 1);
  for (const size_t row : {9u, 10u, 15u}) sums.want_begin(row);
  sums.reserve();
  sums.make(plane.memory(), plane.stride(), 5);
  sums.make(plane.memory(), plane.stride(), 19);
  const std::vector<std::pair<size_t, size_t>> runs{{1, 3},  {4, 4},  {8, 1},  {9, 1},
                                                    {10, 2}, {12, 3}, {15, 1}, {16, 3}};
  EXPECT_EQ(sums.sums_of(1, 18, 64), runs.size());
  for (const auto& [row, rows] : runs) {
    EXPECT_EQ(sums.sums_of(row, rows, 64), 1u) << row;
    EXPECT_EQ(sums.row(row, 64)[0], plane.sum(row, rows, 0, 64, 0)) << row;
  }
}

TEST(BlockSums, TakeAsManyRowsAtOnceAsAllWantersCan) {
  const Upwards plane(1);
  BlockSums sums({0, 0, 256, 1});
  sums.want(0, 16, 4, 8);
  sums.want(2, 16, 4, 2);
  sums.reserve();
  sums.make(plane.memory(), plane.stride(), 16);
  expect_sums(sums, plane, {0, 16, 4, 2});
  sums.clear();
  sums.want(8, 16, 4, 8);
  sums.reserve();
  sums.make(plane.memory(), plane.stride(), 16);
  expect_sums(sums, plane, {8, 16, 4, 8});
}

TEST(BlockSums, AreBlendedWithTheWeightsOfTheirRows) {
  constexpr size_t kStride = 150, kMostRows = 40;
  std::mt19937 random(6);
  std::vector<uint16_t> numbers(kStride * kMostRows + 2 * kRowBlock);
  for (auto& number : numbers) number = static_cast<uint16_t>(random() % 4081);  // 16 * 255
  for (const size_t step : {1u, 2u})
    for (const size_t count : {1u, 2u, 3u, 17u, 18u, 19u, 40u})
      for_each_target([&] {
        const size_t blocks = kStride / step;
        const SumBlend blend{numbers.data(), kStride, count, 0.25f, 0.5f, 0.125f, 16};
        std::vector<float> lanes[2];
        for (auto& lane : lanes) lane.resize(padded(blocks));
        float* const out[2] = {lanes[0].data(), lanes[1].data()};
        blend_sums(blend, step, blocks, out);
        for (size_t i = 0; i < blocks * step; ++i) {
          double sum = 0.25 * numbers[i];
          for (size_t k = 1; k < count; ++k)
            sum += (k + 1 < count ? 0.5 : 0.125) * numbers[k * kStride + i];
          ASSERT_EQ(lanes[i % step][i / step], sum) << step << ", " << count << " rows, " << i;
        }
      });
}

TEST(BlockSums, AreAddedUpAndShifted) {
  constexpr size_t kStride = 150, kMostRows = 8;
  std::mt19937 random(8);
  std::vector<uint16_t> numbers(kStride * kMostRows + 2 * kRowBlock);
  for (auto& number : numbers) number = static_cast<uint16_t>(random() % 1021);  // 4 * 255
  numbers[0] = 1020;
  for (const auto& [count, shift] : {std::pair{1u, 5u}, {2u, 4u}, {3u, 3u}, {8u, 2u}})
    for_each_target([&] {
      std::vector<int16_t> out(padded(kStride));
      add_sums({numbers.data(), kStride, count}, kStride, shift, out.data());
      for (size_t i = 0; i < kStride; ++i) {
        int sum = 0;
        for (size_t k = 0; k < count; ++k) sum += numbers[k * kStride + i];
        ASSERT_EQ(out[i], sum << shift) << count << " rows, " << i;
      }
    });
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

// More rows than 16 bits hold the sums of.
TEST(PlanOfBlocks, OfTallPicturesAreExactToo) {
  for (const char* format : {"GRAY8", "NV12"}) {
    const Pixels pixels(format, 64, 1024, 3);
    for (const auto& [width, height] : {std::pair{16u, 4u}, {4u, 4u}, {2u, 3u}, {1u, 1u}}) {
      const auto p = of_area(pixels, width, height);
      const auto wanted = testing::reference(p, pixels);
      for_each_target([&] {
        const auto out = testing::run<float>(p, pixels);
        for (size_t i = 0; i < out.size(); ++i)
          ASSERT_NEAR(double{out[i]}, wanted[i], 1.0 / 256) << width << "x" << height;
      });
    }
  }
}

// More than float32 holds the sums of, with rows that layers share in other ways in each part.
TEST(PlanOfBlocks, OfTallPicturesDoNotDependOnOtherLayersOrThreads) {
  Pixels pixels("GRAY8", 64, 2048, 3);
  for (auto& byte : pixels.memory) byte |= std::byte{224};
  std::vector<Plan> plans;
  std::vector<std::vector<float>> alone;
  for (const uint32_t height : {1u, 2u, 3u, 7u}) {
    const auto p = of_area(pixels, 1, height);
    plans.push_back(*Plan::make(p));
    alone.push_back(testing::run<float>(p, pixels));
  }
  for (const size_t threads : {1u, 2u, 3u}) {
    Runner runner(threads);
    std::vector<std::vector<float>> out;
    for (const auto& one : alone) out.emplace_back(one.size());
    std::vector<Job> jobs;
    for (size_t i = 0; i < plans.size(); ++i)
      jobs.push_back({&plans[i], std::as_writable_bytes(std::span(out[i]))});
    ASSERT_TRUE(runner.run(pixels.planes, jobs));
    EXPECT_EQ(out, alone) << threads << " threads";
  }
}

TEST(PlanOfBlocks, GivesWhatTheFormulasSay) {
  for (const char* format : {"GRAY8", "RGB", "NV12", "I420"})
    for (const uint32_t height : {21u, 32u, 64u}) {
      Pixels pixels(format, 384, height, 5, 3);
      const double most = pixels.picture.format.model == ColorModel::Yuv ? 1.0 / 16 : 1.0 / 64;
      for (const uint32_t width : {96u, 48u, 12u, 2u, 1u})
        for (const bool second : {false, true}) {
          pixels.picture.cosited_columns = second;
          auto p = of_area(pixels, width, 8);
          if (second && width < 96) p.crop = Rect{96, 3, 288, 17};
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

// Two rows at once, of which another layer wants each: they begin where no four rows do.
TEST(PlanOfBlocks, LayersThatShareSomeRowsOnlyAreThoseOfPlansAlone) {
  const Pixels pixels("GRAY8", 48, 122, 5);
  std::vector<Plan> plans;
  std::vector<std::vector<float>> wanted, out;
  std::vector<Job> jobs;
  for (const uint32_t height : {2u, 11u}) {
    auto p = of_area(pixels, 1, height);
    p.crop = Rect{12, 78, 24, 32};
    plans.push_back(*Plan::make(p));
    wanted.push_back(testing::run<float>(p, pixels));
    out.emplace_back(wanted.back().size());
  }
  for (size_t i = 0; i < plans.size(); ++i)
    jobs.push_back({&plans[i], std::as_writable_bytes(std::span(out[i]))});
  Runner runner(1);
  ASSERT_TRUE(runner.run(pixels.planes, jobs));
  EXPECT_EQ(out, wanted);
}

// Layers of any sizes, of parts of the picture that change from frame to frame: each gives what it
// gives alone, and what the formulas say.
TEST(PlanOfBlocks, RandomLayersAndPartsOfPicturesAgree) {
  for (uint32_t seed = 1; seed <= 12; ++seed) {
    std::mt19937 random(seed);
    const auto any = [&](uint32_t from, uint32_t to) {
      return from + static_cast<uint32_t>(random() % (to - from + 1));
    };
    const char* const formats[] = {"GRAY8", "NV12", "I420", "RGB"};
    const uint32_t width = any(4, 40) * 8, height = any(1, 150);
    Pixels pixels(formats[seed % 4], width, height, seed, any(0, 9));
    pixels.picture.cosited_columns = any(0, 1);
    pixels.picture.cosited_rows = any(0, 1);
    Runner runner(any(1, 3));
    for (int frame = 0; frame < 3; ++frame) {
      std::optional<Rect> crop;
      if (frame > 0) {
        const uint32_t x = any(0, width / 16) * 4, y = any(0, height - 1);
        crop = Rect{x, y, any(1, (width - x) / 4) * 4, any(1, height - y)};
      }
      const uint32_t w = crop ? crop->width : width, h = crop ? crop->height : height;
      std::vector<Preparation> layers;
      std::vector<Plan> plans;
      std::vector<std::vector<float>> out;
      for (uint32_t left = any(1, 4); left > 0; --left) {
        const uint32_t factor = 2u << any(0, 5);
        auto layer = of_area(pixels, std::max(1u, any(0, 3) > 0 ? w / factor : any(1, 20)),
                             std::max(1u, any(0, 1) > 0 ? h / factor : any(1, 20)));
        layer.crop = crop;
        layers.push_back(layer);
        plans.push_back(*Plan::make(layer));
        out.emplace_back(layer.channels() * layer.width * layer.height);
      }
      std::vector<Job> jobs;
      for (size_t i = 0; i < plans.size(); ++i)
        jobs.push_back({&plans[i], std::as_writable_bytes(std::span(out[i]))});
      ASSERT_TRUE(runner.run(pixels.planes, jobs));
      for (size_t i = 0; i < layers.size(); ++i) {
        SCOPED_TRACE("seed " + std::to_string(seed) + ", frame " + std::to_string(frame) +
                     ", layer " + std::to_string(i));
        ASSERT_EQ(out[i], testing::run<float>(layers[i], pixels));
        const auto wanted = testing::reference(layers[i], pixels);
        for (size_t k = 0; k < wanted.size(); ++k)
          ASSERT_NEAR(double{out[i][k]}, wanted[k], 1.0 / 16) << "element " << k;
      }
    }
  }
}

// Big enough for several stripes; layers of whole blocks and others, letterboxed ones too.
TEST(PlanOfBlocks, LayersOfAPyramidAreThoseOfPlansAlone) {
  for (const uint32_t seed : {1u, 2u}) {
    Pixels pixels("NV12", 1024, 1100, seed);
    pixels.picture.cosited_columns = seed == 2;
    for (const Fit fit : {Fit::Stretch, Fit::Letterbox}) {
      std::vector<Plan> plans;
      std::vector<std::vector<float>> wanted;
      for (const auto& [width, height] : {std::pair{512u, 275u},
                                          {256u, 275u},
                                          {256u, 100u},
                                          {128u, 275u},
                                          {100u, 77u},
                                          {64u, 68u},
                                          {3u, 5u},
                                          {1u, 1u}}) {
        auto p = of_area(pixels, width, height);
        p.fit = fit;
        plans.push_back(*Plan::make(p));
        wanted.push_back(testing::run<float>(p, pixels));
      }
      for (const size_t threads : {1u, 3u}) {
        Runner runner(threads);
        Pixels other("NV12", 1024, 1100, seed + 7);
        for (Pixels* frame : {&other, &pixels}) {
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
