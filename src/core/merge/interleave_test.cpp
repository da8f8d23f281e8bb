// Compares interleaved rows with a plain loop, on every SIMD target of this CPU.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/merge/interleave.hpp"

#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <numeric>
#include <vector>

namespace weir {
namespace interleave_test {

using Bytes = std::vector<std::byte>;

// Each input has its exact size, so that sanitizers detect overreads.
std::vector<Bytes> inputs_of(const std::vector<size_t>& blocks, size_t rows) {
  std::vector<Bytes> out;
  for (size_t i = 0; i < blocks.size(); ++i) {
    out.emplace_back(blocks[i] * rows);
    for (size_t n = 0; n < out.back().size(); ++n)
      out.back()[n] = static_cast<std::byte>(n * 7 + i * 50 + 1);
  }
  return out;
}

Bytes plain(const std::vector<Bytes>& inputs, const std::vector<size_t>& blocks, size_t rows) {
  Bytes out;
  for (size_t row = 0; row < rows; ++row)
    for (size_t i = 0; i < blocks.size(); ++i)
      for (size_t b = 0; b < blocks[i]; ++b) out.push_back(inputs[i][row * blocks[i] + b]);
  return out;
}

// The written rows must be right, and nothing may be written after the end.
size_t check(const std::vector<size_t>& blocks, size_t rows) {
  const auto inputs = inputs_of(blocks, rows);
  const std::vector<std::span<const std::byte>> views(inputs.begin(), inputs.end());
  const size_t row = std::accumulate(blocks.begin(), blocks.end(), size_t{0});
  Bytes out(row * rows);
  const size_t done = interleave_rows(views, blocks, rows, out.data());
  EXPECT_LE(done, rows);
  auto expected = plain(inputs, blocks, rows);
  expected.resize(done * row);
  out.resize(done * row);
  EXPECT_EQ(out, expected) << rows << " rows of " << row << " bytes";
  return done;
}

TEST(Interleave, AgreesWithAPlainLoopOnEachTarget) {
  const std::vector<size_t> lines[] = {{1, 1},    {3, 3},       {4, 4},       {1, 3},   {3, 1},
                                       {8, 8},    {2, 6},       {15, 1},      {6, 6},   {1, 1, 1},
                                       {3, 3, 3}, {1, 2, 4},    {4, 4, 4, 4}, {12, 4},  {5, 2},
                                       {9, 7},    {1, 1, 1, 1}, {2, 1, 3},    {7, 1, 8}};
  for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    SCOPED_TRACE(hwy::TargetName(target));
    for (const auto& blocks : lines)
      for (const size_t rows : {1u, 5u, 16u, 17u, 18u, 33u, 100u}) check(blocks, rows);
  }
  hwy::SetSupportedTargetsForTest(0);
}

TEST(Interleave, LeavesNoMoreThanAVectorToThePlainLoop) {
  if (hwy::SupportedTargets() == HWY_STATIC_TARGET) GTEST_SKIP() << "no shuffles here";
  EXPECT_GE(check({3, 3}, 1000), 992u);
  EXPECT_GE(check({4, 4, 4, 4}, 1000), 995u);
}

TEST(Interleave, SkipsLongRowsAndManyInputs) {
  EXPECT_EQ(check({16, 1}, 100), 0u);
  EXPECT_EQ(check({1, 1, 1, 1, 1}, 100), 0u);
  EXPECT_EQ(check({4}, 100), 0u);
}

}  // namespace interleave_test
}  // namespace weir
