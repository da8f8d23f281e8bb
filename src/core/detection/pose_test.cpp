// Tests of heat maps and offsets, with expected values in closed form and from NumPy.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/detection/pose.hpp"
#include "core/tensor/geometry.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace weir::detection {
namespace pose_test {

using Peaks = std::vector<HeatPeak>;

Peaks peaks_of(const std::vector<float>& maps, const HeatGrid& grid,
               Heat heat = Heat::Probability) {
  EXPECT_EQ(maps.size(), grid.values());
  Peaks out(grid.points, {99, 99, 99});
  find_peaks(maps, grid, heat, out);
  return out;
}

TEST(FindPeaks, FindsTheCellOfEachKeyPoint) {
  // Two key points on a grid of 3 x 2.
  EXPECT_EQ(peaks_of({0.1f, 0.9f, 0.2f, 0.1f, 0.3f, 0.1f,  //
                      0.4f, 0.1f, 0.8f, 0.1f, 0.6f, 0.2f},
                     {2, 3, 2}),
            (Peaks{{1, 1, 0.8f}, {0, 0, 0.9f}}));
}

TEST(FindPeaks, TakesTheFirstOfEqualCells) {
  EXPECT_EQ(peaks_of({0, 0.75f, 0.75f, 0.75f}, {1, 2, 2}), (Peaks{{1, 0, 0.75f}}));
  EXPECT_EQ(peaks_of({-1, -1, -1, -1}, {1, 2, 2}), (Peaks{{0, 0, -1}}));
}

TEST(FindPeaks, AppliesTheSigmoidToLogits) {
  const auto found = peaks_of({-3, 0, 2, 1}, {1, 4, 1}, Heat::Logit)[0];
  EXPECT_EQ(found.column, 2u);
  EXPECT_FLOAT_EQ(found.probability, static_cast<float>(1 / (1 + std::exp(-2.0))));
  EXPECT_EQ(peaks_of({0, -1}, {1, 2, 1}, Heat::Logit), (Peaks{{0, 0, 0.5f}}));
}

// Their sigmoids are all 1 in float32: the first is not exceeded.
TEST(FindPeaks, TakesTheFirstOfLogitsWithEqualSigmoids) {
  EXPECT_EQ(peaks_of({-1, 30, 40, INFINITY}, {1, 4, 1}, Heat::Logit), (Peaks{{1, 0, 1}}));
  EXPECT_EQ(peaks_of({-1, 30, 40, INFINITY}, {1, 4, 1}), (Peaks{{3, 0, INFINITY}}));
}

TEST(FindPeaks, NeverChoosesNotANumber) {
  for (const Heat heat : {Heat::Probability, Heat::Logit}) {
    const auto found = peaks_of({NAN, 0.1f, 0.7f, NAN}, {1, 4, 1}, heat)[0];
    EXPECT_EQ(found.column, 2u);
    EXPECT_GT(found.probability, 0.5f);
    EXPECT_EQ(peaks_of({NAN, NAN, -INFINITY, NAN}, {1, 4, 1}, heat), (Peaks{{0, 0, 0}}));
  }
}

// numpy: m = ((np.arange(7 * 5 * 70) * 7919 % 2477) / 2477).astype('f4').reshape(35, 70)
//        m.argmax(0)[[0, 1, 31, 32, 33, 63, 64, 69]]
TEST(FindPeaks, AgreesWithNumPyForManyKeyPoints) {
  const HeatGrid grid{70, 7, 5};
  std::vector<float> maps(grid.values()), logits;
  for (size_t i = 0; i < maps.size(); ++i)
    maps[i] = static_cast<float>(static_cast<double>(i * 7919 % 2477) / 2477);
  for (const float value : maps) logits.push_back(10 * value - 5);
  const Peaks found = peaks_of(maps, grid), of_logits = peaks_of(logits, grid, Heat::Logit);
  std::vector<size_t> cells;
  for (const size_t point : {0u, 1u, 31u, 32u, 33u, 63u, 64u, 69u})
    cells.push_back(found[point].row * 7 + found[point].column);
  EXPECT_EQ(cells, (std::vector<size_t>{24, 1, 34, 16, 12, 2, 3, 22}));
  for (size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(of_logits[i].column, found[i].column) << i;
    EXPECT_EQ(of_logits[i].row, found[i].row) << i;
  }
}

TEST(PositionWithOffset, SpreadsTheCellsOverTheInputAndAddsTheOffset) {
  const HeatGrid grid{2, 5, 3};
  std::vector<float> offsets(2 * grid.values());
  const size_t cell = (1 * 5 + 4) * 4;
  offsets[cell] = 7;          // y of key point 0
  offsets[cell + 1] = -1.5f;  // y of key point 1
  offsets[cell + 2] = 2;      // x of key point 0
  offsets[cell + 3] = -9;     // x of key point 1
  const Size input{321, 240};
  EXPECT_EQ(position_with_offset({4, 1, 1}, grid, offsets, 0, input), (PosePoint{323, 127}));
  EXPECT_EQ(position_with_offset({4, 1, 1}, grid, offsets, 1, input), (PosePoint{312, 118.5f}));
  EXPECT_EQ(position_with_offset({0, 0, 1}, grid, offsets, 0, input), (PosePoint{0, 0}));
  EXPECT_EQ(position_with_offset({1, 2, 1}, grid, offsets, 0, input), (PosePoint{80.25f, 240}));
}

TEST(PositionWithOffset, IsNotFiniteWithSuchAnOffset) {
  const HeatGrid grid{1, 2, 2};
  const std::vector<float> offsets{NAN, 0, 0, INFINITY, 0, 0, 0, 0};
  EXPECT_TRUE(std::isnan(position_with_offset({0, 0, 1}, grid, offsets, 0, {9, 9}).y));
  EXPECT_TRUE(std::isinf(position_with_offset({1, 0, 1}, grid, offsets, 0, {9, 9}).x));
}

}  // namespace pose_test
}  // namespace weir::detection
