// Tests of output shapes from the names of open dimensions.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "onnxruntime/symbolic_shapes.hpp"

#include <gtest/gtest.h>

namespace weir::engine {
namespace symbolic_shapes_test {

weir_tensor_info shaped(const std::vector<int64_t>& shape) {
  weir_tensor_info info{};
  info.rank = static_cast<uint32_t>(shape.size());
  std::copy(shape.begin(), shape.end(), info.shape);
  return info;
}

TEST(SymbolicShapes, NamesGetTheSizesOfTheInputs) {
  const std::vector inputs{shaped({8, 3, 32, 64}), shaped({5})};
  std::vector outputs{shaped({-1, -1, 2}), shaped({-1})};
  substitute_symbols(inputs, {{"n", "", "h", "w"}, {"k"}}, outputs, {{"w", "n", ""}, {"k"}});
  EXPECT_EQ(outputs[0].shape[0], 64);
  EXPECT_EQ(outputs[0].shape[1], 8);
  EXPECT_EQ(outputs[0].shape[2], 2);
  EXPECT_EQ(outputs[1].shape[0], 5);
}

TEST(SymbolicShapes, UnknownNamesStayOpen) {
  std::vector outputs{shaped({-1, -1})};
  substitute_symbols(std::vector{shaped({8})}, {{"n"}}, outputs, {{"h", ""}});
  EXPECT_EQ(outputs[0].shape[0], -1);
  EXPECT_EQ(outputs[0].shape[1], -1);
}

TEST(SymbolicShapes, ANameWithTwoSizesIsIgnored) {
  std::vector outputs{shaped({-1})};
  substitute_symbols(std::vector{shaped({8}), shaped({9})}, {{"n"}, {"n"}}, outputs, {{"n"}});
  EXPECT_EQ(outputs[0].shape[0], -1);
}

TEST(SymbolicShapes, AFixedDimensionIsNotChanged) {
  std::vector outputs{shaped({4})};
  substitute_symbols(std::vector{shaped({8})}, {{"n"}}, outputs, {{"n"}});
  EXPECT_EQ(outputs[0].shape[0], 4);
}

TEST(SymbolicShapes, OpenInputsDefineNoSizes) {
  std::vector outputs{shaped({-1})};
  substitute_symbols(std::vector{shaped({-1})}, {{"n"}}, outputs, {{"n"}});
  EXPECT_EQ(outputs[0].shape[0], -1);
}

TEST(SymbolicShapes, UnknownRanksAndMissingNamesStayOpen) {
  auto unknown = shaped({});
  unknown.rank = WEIR_RANK_UNKNOWN;
  std::vector outputs{unknown, shaped({-1})};
  substitute_symbols(std::vector{unknown}, {}, outputs, {{"n"}});
  EXPECT_EQ(outputs[0].rank, WEIR_RANK_UNKNOWN);
  EXPECT_EQ(outputs[1].shape[0], -1);
}

}  // namespace symbolic_shapes_test
}  // namespace weir::engine
