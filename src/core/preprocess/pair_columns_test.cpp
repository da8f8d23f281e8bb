// Compares blended pairs with the same arithmetic one number at a time.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/preprocess/pair_columns.hpp"

#include <gtest/gtest.h>

#include <random>

#include "core/preprocess/pair_kernels.hpp"
#include "core/preprocess/row_kernels.hpp"
#include "core/preprocess/wide_windows.hpp"
#include "core/transform/avx512_bytes.hpp"
#include "core/transform/transform_test_support.hpp"

namespace weir::preprocess {
namespace {

int times_share(int difference, int share) {
  return (difference * share + (1 << 14)) >> 15;
}

// A row of random samples in memory of exactly its size, so that AddressSanitizer detects
// overreads.
struct Rows {
  std::vector<uint8_t> above, below;
  Rows(size_t bytes, uint32_t seed) : above(bytes), below(bytes) {
    std::mt19937 random(seed);
    for (auto& byte : above) byte = static_cast<uint8_t>(random());
    for (auto& byte : below) byte = static_cast<uint8_t>(random());
  }
};

void expect_blended(const Axis& axis, size_t step, size_t row_count, const PairColumns& columns) {
  const Rows rows((axis.high() - axis.low()) * step, 3);
  const size_t lanes = pair_lanes(step), count = axis.targets();
  std::vector<std::byte> pairs[2];
  for (auto& one : pairs) one.resize(pairs_memory(padded(count), step));
  std::byte* const taken[2] = {pairs[0].data(), pairs[1].data()};
  const uint8_t* const from[2] = {rows.above.data(), rows.below.data()};
  std::vector<int16_t> out(padded(count) * lanes);
  const int16_t down = pair_share(0.3);
  blend_pairs({from, from, row_count}, columns, down, taken, out.data());
  for (size_t t = 0; t < count; ++t)
    for (size_t l = 0; l < step; ++l) {
      const auto blended = [&](const std::vector<uint8_t>& row) {
        const auto weights = axis.weights(t);
        const size_t at = (axis.first(t) - axis.low()) * step + l;
        if (weights.size() == 1) return 128 * row[at];
        const int first = 128 * row[at], second = 128 * row[at + step];
        return first + times_share(first - second, pair_share(double{weights[1]}));
      };
      int wanted = blended(rows.above);
      if (row_count == 2) wanted += times_share(wanted - blended(rows.below), down);
      ASSERT_EQ(out[t * lanes + l], wanted) << "pixel " << t << " lane " << l;
    }
}

TEST(PairColumns, BlendsTheNeighboursOfEachPixel) {
  for (size_t step = 1; step <= 4; ++step)
    for (const auto& [length, targets] : {std::pair{2u, 1u},
                                          {2u, 9u},
                                          {5u, 5u},
                                          {40u, 90u},
                                          {40u, 39u},
                                          {64u, 33u},
                                          {90u, 30u},
                                          {90u, 21u},
                                          {200u, 25u},
                                          {330u, 70u},
                                          {500u, 70u},
                                          {300u, 3u},
                                          {1300u, 90u},
                                          {1300u, 41u},
                                          {2000u, 17u}})
      for (const Resize resize : {Resize::Bilinear, Resize::Nearest}) {
        SCOPED_TRACE(std::to_string(step) + ": " + std::to_string(length) + " to " +
                     std::to_string(targets));
        const Axis axis(resize, {7, length, targets}, {});
        PairColumns columns;
        transform::test::for_each_target([&] {
          columns.lay(axis, step);
          expect_blended(axis, step, 1, columns);
          expect_blended(axis, step, 2, columns);
        });
      }
}

PairColumns laid(size_t step, uint32_t length, uint32_t targets) {
  PairColumns columns;
  columns.lay(Axis(Resize::Bilinear, {0, length, targets}, {}), step);
  return columns;
}

TEST(PairColumns, LooksUpNearNeighboursTogether) {
  transform::allow_avx512_bytes(false);
  EXPECT_EQ(laid(1, 64, 64).group, 8u);
  EXPECT_EQ(laid(1, 192, 64).group, 4u);
  EXPECT_EQ(laid(1, 640, 64).group, 1u);
  EXPECT_EQ(laid(2, 192, 64).group, 2u);
  EXPECT_EQ(laid(3, 192, 64).group, 2u);
  EXPECT_EQ(laid(4, 64, 64).group, 2u);
  EXPECT_EQ(laid(4, 192, 64).group, 1u);
  EXPECT_EQ(laid(1, 15, 15).group, 1u);  // a window is longer than the row
  transform::allow_avx512_bytes(true);
}

TEST(PairColumns, UsesWholeVectorWindowsIfTheCpuHasThem) {
  if (!has_wide_windows()) GTEST_SKIP() << "no AVX-512 with VBMI";
  EXPECT_EQ(laid(1, 64, 64).wide, 1u);
  EXPECT_EQ(laid(1, 640, 320).wide, 1u);
  EXPECT_EQ(laid(1, 960, 320).wide, 2u);
  EXPECT_EQ(laid(1, 1280, 320).wide, 2u);
  EXPECT_EQ(laid(1, 1600, 320).wide, 3u);
  EXPECT_EQ(laid(1, 2240, 320).wide, 4u);
  EXPECT_EQ(laid(2, 960, 320).wide, 2u);
  EXPECT_EQ(laid(4, 640, 160).wide, 2u);
  EXPECT_EQ(laid(3, 1280, 160).wide, 3u);
  EXPECT_EQ(laid(1, 63, 63).wide, 0u);  // a window is longer than the row
}

// The bytes that a whole vector of pixels needs do not fit into four vectors.
TEST(PairColumns, AssemblesVectorsFromWindowsForFarNeighbours) {
  if (!has_wide_windows()) GTEST_SKIP() << "no AVX-512 with VBMI";
  const auto windows = [](size_t step, uint32_t factor) {
    const PairColumns columns = laid(step, 320 * factor, 320);
    return std::pair(columns.wide, columns.wide_lanes);
  };
  EXPECT_EQ(windows(1, 7), std::pair(size_t{4}, size_t{32}));
  EXPECT_EQ(windows(1, 9), std::pair(size_t{3}, size_t{16}));   // 15 * 9 + 2 bytes
  EXPECT_EQ(windows(1, 16), std::pair(size_t{4}, size_t{16}));  // 15 * 16 + 2
  EXPECT_EQ(windows(1, 20), std::pair(size_t{3}, size_t{8}));   // 7 * 20 + 2
  EXPECT_EQ(windows(1, 36), std::pair(size_t{4}, size_t{8}));   // 7 * 36 + 2
  EXPECT_EQ(windows(1, 37).first, 0u);
  EXPECT_EQ(windows(2, 20), std::pair(size_t{2}, size_t{8}));   // 3 * 40 + 4
  EXPECT_EQ(windows(4, 20), std::pair(size_t{4}, size_t{16}));  // 3 * 80 + 8
}

TEST(PairColumns, HoldsTheWholeSecondSample) {
  EXPECT_EQ(pair_share(0), 0);
  EXPECT_EQ(pair_share(0.5), -16384);
  EXPECT_EQ(pair_share(1), -32768);
}

}  // namespace
}  // namespace weir::preprocess
