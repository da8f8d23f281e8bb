// Strided tensors: their extent, and their runs in element order.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/tensor/strided_layout.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace weir {
namespace strided_layout_test {

// Offsets of all elements by the definition: offset + sum of index times stride.
std::vector<int64_t> offsets_of(const TensorSpec& tensor, const StridedLayout& layout) {
  std::vector<int64_t> out;
  for (uint64_t n = 0; n < *tensor.shape.count(); ++n) {
    uint64_t rest = n;
    auto offset = static_cast<int64_t>(layout.offset);
    for (size_t i = 0; i < tensor.shape.rank(); ++i) {
      offset += static_cast<int64_t>(rest % tensor.shape[i]) * layout.strides[i];
      rest /= tensor.shape[i];
    }
    out.push_back(offset);
  }
  return out;
}
std::vector<int64_t> offsets_of(const Runs& runs, size_t element) {
  std::vector<int64_t> out;
  for_each_run(runs, [&](uint64_t offset) {
    for (uint64_t i = 0; i < runs.bytes; i += element)
      out.push_back(static_cast<int64_t>(offset + i));
    return true;
  });
  return out;
}

TEST(StridedLayout, DenseTensorsAreOneRun) {
  const TensorSpec tensor{ElementType::UInt16, {3, 5, 7}, ""};
  const StridedLayout dense{8, {2, 6, 30}};
  EXPECT_EQ(find_extent(tensor, dense), 8u + 210);
  const Runs runs = make_runs(tensor, dense);
  EXPECT_TRUE(runs.steps.empty());
  EXPECT_EQ(runs.bytes, 210u);
  EXPECT_EQ(runs.offset, 8u);
}

TEST(StridedLayout, PaddedRowsAreARunEach) {
  const Runs runs = make_runs({ElementType::UInt8, {3, 5, 4, 1}, ""}, {0, {1, 3, 16, 999}});
  EXPECT_EQ(runs.bytes, 15u);
  ASSERT_EQ(runs.steps.size(), 1u);
  EXPECT_EQ(runs.steps[0].count, 4u);
  EXPECT_EQ(runs.steps[0].stride, 16);
}

TEST(StridedLayout, DimensionsThatContinueEachOtherAreOne) {
  const Runs runs = make_runs({ElementType::UInt8, {2, 4, 3}, ""}, {0, {1, 10, 40}});
  ASSERT_EQ(runs.steps.size(), 1u);
  EXPECT_EQ(runs.steps[0].count, 12u);
}

TEST(StridedLayout, RowsFromBottomToTopHaveANegativeStride) {
  const TensorSpec tensor{ElementType::UInt8, {4, 3}, ""};
  EXPECT_EQ(find_extent(tensor, {8, {1, -4}}), 12u);
  EXPECT_EQ(offsets_of(make_runs(tensor, {8, {1, -4}}), 1),
            (std::vector<int64_t>{8, 9, 10, 11, 4, 5, 6, 7, 0, 1, 2, 3}));
}

TEST(StridedLayout, FollowsTheDefinitionForRandomLayouts) {
  std::mt19937 random(3);
  for (int round = 0; round < 500; ++round) {
    TensorSpec tensor{round % 2 ? ElementType::UInt8 : ElementType::Float32, {}, ""};
    StridedLayout layout;
    const size_t rank = 1 + random() % 5;
    for (size_t i = 0; i < rank; ++i) {
      tensor.shape[i] = 1 + random() % 4;
      layout.strides.push_back(static_cast<int64_t>(random() % 100) - 40);
    }
    if (round % 3 == 0) layout.strides[0] = static_cast<int64_t>(element_size(tensor.type));
    layout.offset = 1000;
    const auto expected = offsets_of(tensor, layout);
    EXPECT_EQ(offsets_of(make_runs(tensor, layout), element_size(tensor.type)), expected);
    EXPECT_EQ(find_extent(tensor, layout),
              static_cast<uint64_t>(*std::max_element(expected.begin(), expected.end())) +
                  element_size(tensor.type));
  }
}

TEST(StridedLayout, RejectsOffsetsOutsideTheMemory) {
  const TensorSpec tensor{ElementType::UInt8, {4, 3}, ""};
  EXPECT_FALSE(find_extent(tensor, {7, {1, -4}}));
  EXPECT_FALSE(find_extent(tensor, {0, {1}}));
  EXPECT_FALSE(find_extent(tensor, {0, {1, INT64_MAX}}));
  EXPECT_FALSE(find_extent(tensor, {UINT64_MAX, {1, 4}}));
  EXPECT_FALSE(find_extent({ElementType::UInt8, {}, ""}, {0, {}}));
}

}  // namespace strided_layout_test
}  // namespace weir
