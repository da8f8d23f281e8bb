// Tests of the inputs of a dry run: zero-filled, bounded, lazily backed.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "dry_run.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "engine_host_test_support.hpp"
#include "out_of_memory_test_support.hpp"
#include "says.hpp"

namespace weir::engine {
namespace dry_run_test {

weir_tensor_info floats(std::initializer_list<int64_t> shape) {
  weir_tensor_info info{};
  info.type = WEIR_FLOAT32;
  for (const int64_t extent : shape) info.shape[info.rank++] = extent;
  return info;
}

TEST(DryRunInputs, AreZerosInTheShapesGiven) {
  const weir_tensor_info infos[] = {floats({2, 3}), floats({})};
  auto inputs = DryRunInputs::create(infos);
  ASSERT_TRUE(inputs) << inputs.error().message();
  const auto tensors = inputs->tensors();
  ASSERT_EQ(tensors.size(), 2u);
  EXPECT_EQ(tensors[0].bytes, 24u);
  EXPECT_EQ(tensors[1].bytes, 4u);
  EXPECT_EQ(tensors[0].info.shape[1], 3);
  const auto* values = static_cast<const float*>(tensors[0].data);
  EXPECT_TRUE(std::all_of(values, values + 6, [](float value) { return value == 0; }));
}

TEST(DryRunInputs, MayBeEmptyTensorsOrNone) {
  const weir_tensor_info empty[] = {floats({0, 3})};
  auto inputs = DryRunInputs::create(empty);
  ASSERT_TRUE(inputs);
  EXPECT_EQ(inputs->tensors()[0].bytes, 0u);
  EXPECT_NE(inputs->tensors()[0].data, nullptr);
  EXPECT_TRUE(DryRunInputs::create({}));
}

TEST(DryRunInputs, UseNoMemoryUntilTheyAreWritten) {
  if (kIsSanitized) GTEST_SKIP() << "sanitizers write shadow memory";
  const weir_tensor_info infos[] = {floats({kDryRunBytes / 4})};
  const uint64_t before = engine_test::peak_resident_bytes();
  const auto inputs = DryRunInputs::create(infos);
  ASSERT_TRUE(inputs) << inputs.error().message();
  EXPECT_LT(engine_test::peak_resident_bytes(), before + kDryRunBytes / 16);
}

TEST(DryRunInputs, BeyondTheLimitAreRejected) {
  const weir_tensor_info one[] = {floats({kDryRunBytes / 4 + 1})};
  const weir_tensor_info two[] = {floats({kDryRunBytes / 4}), floats({1})};
  for (const std::span<const weir_tensor_info> infos :
       {std::span<const weir_tensor_info>(one), std::span<const weir_tensor_info>(two)}) {
    const auto inputs = DryRunInputs::create(infos);
    ASSERT_FALSE(inputs);
    EXPECT_EQ(inputs.error().code, Code::LIMIT_EXCEEDED);
    EXPECT_SAYS(inputs.error().message(), "the inputs are too large for a dry run");
    EXPECT_SAYS(inputs.error().message(), "at most 1073741824 bytes together");
  }
}

TEST(DryRunInputs, WithoutASizeAreRejected) {
  for (const auto& info : {floats({-1, 3}), floats({int64_t{1} << 40, int64_t{1} << 40})}) {
    const auto inputs = DryRunInputs::create({&info, 1});
    ASSERT_FALSE(inputs);
    EXPECT_EQ(inputs.error().code, Code::SPEC_MISMATCH);
    EXPECT_SAYS(inputs.error().message(), "an input has an impossible size");
  }
}

}  // namespace dry_run_test
}  // namespace weir::engine
