// SampleOrder: ranges, passes and shuffling.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/dataset/sample_order.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "says.hpp"

namespace weir::dataset {
namespace sample_order_test {

using Indices = std::vector<uint64_t>;

Indices all(SampleOrder order) {
  Indices out;
  while (const auto index = order.next()) out.push_back(*index);
  EXPECT_FALSE(order.next());
  return out;
}
Indices all(const OrderRequest& request, uint64_t samples) {
  const auto order = SampleOrder::make(request, samples);
  EXPECT_TRUE(order);
  return order ? all(*order) : Indices{};
}
Indices pass(const Indices& of, size_t number, size_t length) {
  const auto start = of.begin() + static_cast<ptrdiff_t>(number * length);
  return {start, start + static_cast<ptrdiff_t>(length)};
}
Indices sorted(Indices of) {
  std::sort(of.begin(), of.end());
  return of;
}

TEST(SampleOrder, IsThatOfTheFileByDefault) {
  EXPECT_EQ(all({}, 4), (Indices{0, 1, 2, 3}));
  EXPECT_EQ(all({}, 1), (Indices{0}));
}

TEST(SampleOrder, IncludesBothEndsOfTheRange) {
  EXPECT_EQ(all({.start = 1, .stop = 3}, 5), (Indices{1, 2, 3}));
  EXPECT_EQ(all({.start = 4, .stop = 4}, 5), (Indices{4}));
}

TEST(SampleOrder, EndsWithTheLastSampleIfTheStopIsZero) {
  EXPECT_EQ(all({.start = 2}, 5), (Indices{2, 3, 4}));
}

TEST(SampleOrder, RepeatsTheRangeInEachPass) {
  EXPECT_EQ(all({.start = 1, .stop = 2, .epochs = 3, .is_shuffled = false}, 5),
            (Indices{1, 2, 1, 2, 1, 2}));
  EXPECT_EQ(all({.epochs = 0}, 5), (Indices{}));
}

TEST(SampleOrder, ShufflesEveryPassButTheFirst) {
  const Indices order = all({.start = 10, .stop = 59, .epochs = 4}, 100);
  ASSERT_EQ(order.size(), 200u);
  const Indices first = pass(order, 0, 50);
  EXPECT_EQ(first, sorted(first));
  EXPECT_EQ(first.front(), 10u);
  for (size_t i = 1; i < 4; ++i) {
    EXPECT_EQ(sorted(pass(order, i, 50)), first) << i;
    EXPECT_NE(pass(order, i, 50), pass(order, i - 1, 50)) << i;  // 1 in 50! by chance
  }
}

TEST(SampleOrder, IsTheSameForTheSameSeed) {
  const OrderRequest request{.epochs = 3, .seed = 7};
  OrderRequest other = request;
  other.seed = 8;
  EXPECT_EQ(all(request, 40), all(request, 40));
  EXPECT_NE(all(request, 40), all(other, 40));
}

TEST(SampleOrder, DiffersFromRunToRunWithoutASeed) {
  EXPECT_NE(all({.epochs = 3}, 100), all({.epochs = 3}, 100));
}

// The rule of io.md 7.2, written as a plain loop.
TEST(SampleOrder, SwapsEachEntryWithARandomOneInPlace) {
  const Indices order = all({.epochs = 3, .seed = 1}, 6);
  std::mt19937_64 random(1);
  Indices list{0, 1, 2, 3, 4, 5};
  for (size_t number = 1; number < 3; ++number) {
    for (size_t i = 0; i < 6; ++i) std::swap(list[i], list[random() % 6]);
    EXPECT_EQ(pass(order, number, 6), list) << number;
  }
}

TEST(SampleOrder, RejectsRangesThatDoNotExist) {
  EXPECT_REFUSED(SampleOrder::make({.start = 5}, 5), OPTION_VALUE,
                 "offered: start-sample-index=5 stop-sample-index=0");
  EXPECT_REFUSED(SampleOrder::make({.stop = 5}, 5), OPTION_VALUE,
                 "needed: indices from 0 to 4, the first not above the last");
  EXPECT_REFUSED(SampleOrder::make({.start = 3, .stop = 2}, 5), OPTION_VALUE,
                 "fix: start-sample-index=0 stop-sample-index=4");
  EXPECT_REFUSED(SampleOrder::make({}, 0), OPTION_VALUE, "needed: a sample: there is none");
}

TEST(SampleOrder, NeedsNoMemoryForARangeThatIsNotShuffled) {
  auto order = SampleOrder::make({.start = 1, .is_shuffled = false}, UINT64_MAX);
  ASSERT_TRUE(order);
  EXPECT_EQ(order->next(), 1u);
  EXPECT_TRUE(SampleOrder::make({.is_shuffled = true}, UINT64_MAX));  // the first pass never is
  EXPECT_REFUSED(SampleOrder::make({.epochs = 2}, UINT64_MAX), LIMIT_EXCEEDED,
                 "fix: is-shuffle=false");
}

}  // namespace sample_order_test
}  // namespace weir::dataset
