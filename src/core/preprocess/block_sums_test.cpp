// Compares sums of blocks with plain loops.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/preprocess/block_sums.hpp"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "core/preprocess/row_kernels.hpp"
#include "core/transform/transform_test_support.hpp"

namespace weir::preprocess {
namespace {

using transform::test::for_each_target;

constexpr size_t kAlone = 13;  // a row that is requested on its own

// Requests the rows [first, end) in blocks of `block` samples; `together` rows may be added.
struct Wanted {
  size_t first, end, block, together;
};

// Rows of random bytes, stored bottom-up.
struct Upwards {
  static constexpr size_t kRows = 19, kSamples = 700;
  explicit Upwards(size_t samples_step) : step(samples_step), bytes(kRows * kSamples * step) {
    std::mt19937 random(4);
    for (auto& byte : bytes) byte = static_cast<uint8_t>(random());
    std::fill_n(bytes.begin(), 3 * kSamples * step, uint8_t{255});  // the largest possible sums
  }
  const uint8_t* memory() const { return bytes.data() + (kRows - 1) * kSamples * step; }
  ptrdiff_t stride() const { return -static_cast<ptrdiff_t>(kSamples * step); }
  int sum(size_t row, size_t rows, size_t sample, size_t samples, size_t lane) const {
    int out = 0;
    for (size_t r = row; r < row + rows; ++r)
      for (size_t i = sample; i < sample + samples; ++i) out += at(r, i, lane);
    return out;
  }
  // Four times the sum from a quarter sample after the first to a quarter sample after the last, if
  // a further sample exists.
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
  const size_t block = wanted.block, low = sums.samples().low, high = sums.samples().high;
  for (size_t row = wanted.first, together = 0; row < wanted.end; row += together) {
    together = 1;  // rows in one row of sums
    while (row + together < wanted.end && sums.of_rows(row, together + 1, block).count == 1)
      ++together;
    ASSERT_LE(together, sums.most_rows_of(block));
    const bool alone = row <= kAlone && kAlone < row + together;
    if (wanted.together > 1) {
      ASSERT_EQ(together, wanted.together);
    } else if (alone) {
      ASSERT_EQ(together, 1u);
    }
    for (size_t b = (low + block - 1) / block, n = 0; b < high / block; ++b, ++n)
      for (size_t l = 0; l < plane.step; ++l)
        ASSERT_EQ(sums.of_rows(row, 1, block).rows[n * plane.step + l],
                  sums.samples().cosited ? plane.shifted_sum(row, together, b * block, block, l,
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

TEST(BlockSums, CoverWholeBlocksOnDemand) {
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

TEST(BlockSums, CoverUpToFourRowsFromAnyStart) {
  const Upwards plane(1);
  BlockSums sums({0, 0, 256, 1});
  sums.want(1, 19, 64, 1);
  for (const size_t row : {9u, 10u, 15u}) sums.want_begin(row);
  sums.reserve();
  sums.make(plane.memory(), plane.stride(), 5);
  sums.make(plane.memory(), plane.stride(), 19);
  const std::vector<std::pair<size_t, size_t>> runs{{1, 3},  {4, 4},  {8, 1},  {9, 1},
                                                    {10, 2}, {12, 3}, {15, 1}, {16, 3}};
  EXPECT_EQ(sums.of_rows(1, 18, 64).count, runs.size());
  for (const auto& [row, rows] : runs) {
    EXPECT_EQ(sums.of_rows(row, rows, 64).count, 1u) << row;
    EXPECT_EQ(sums.of_rows(row, 1, 64).rows[0], plane.sum(row, rows, 0, 64, 0)) << row;
  }
}

TEST(BlockSums, ReadAsManyRowsAtOnceAsAllLayersAllow) {
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
        const SumBlend blend{{numbers.data(), kStride, count}, 0.25f, 0.5f, 0.125f, 16};
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

}  // namespace
}  // namespace weir::preprocess
