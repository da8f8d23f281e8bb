// Compares sums with closed forms and a plain loop, on every SIMD target of this CPU.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/condition/narrow_sum.hpp"

#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <cstring>
#include <functional>
#include <random>
#include <vector>

namespace weir::condition {
namespace narrow_sum_test {

void on_each_target(const std::function<void()>& check) {
  for (const int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    SCOPED_TRACE(hwy::TargetName(target));
    check();
  }
  hwy::SetSupportedTargetsForTest(0);
}

template <class T>
int64_t sum_of(std::span<const std::byte> bytes) {
  return sizeof(T) == 1 ? sum_of_bytes(bytes, std::is_signed_v<T>)
                        : sum_of_words(bytes, std::is_signed_v<T>);
}

template <class T>
class NarrowSum : public testing::Test {};
using Types = testing::Types<uint8_t, int8_t, uint16_t, int16_t>;
TYPED_TEST_SUITE(NarrowSum, Types);

// Every alignment within a vector, in memory of the exact size, so that sanitizers detect
// overreads.
TYPED_TEST(NarrowSum, AgreesWithAPlainLoop) {
  using T = TypeParam;
  on_each_target([] {
    std::mt19937 random(3);
    for (const size_t count : {0u, 1u, 2u, 15u, 31u, 32u, 33u, 127u, 128u, 129u, 1000u}) {
      for (size_t moved = 0; moved < 65; moved += 1 + random() % 3) {
        std::vector<std::byte> bytes(moved + count * sizeof(T));
        int64_t expected = 0;
        for (size_t i = 0; i < count; ++i) {
          const auto value = static_cast<T>(random());
          std::memcpy(bytes.data() + moved + i * sizeof(T), &value, sizeof value);
          expected += value;
        }
        EXPECT_EQ(sum_of<T>(std::span(bytes).subspan(moved)), expected) << count << " at " << moved;
      }
    }
  });
}

// More of the largest and smallest values than a 32-bit lane can sum.
TYPED_TEST(NarrowSum, IsExactForManyOfTheLargest) {
  using T = TypeParam;
  on_each_target([] {
    constexpr size_t kCount = 3'000'001;
    for (const T value : {std::numeric_limits<T>::max(), std::numeric_limits<T>::min()}) {
      const std::vector<T> values(kCount, value);
      EXPECT_EQ(sum_of<T>(std::as_bytes(std::span(values))), int64_t{kCount} * value);
    }
  });
}

}  // namespace narrow_sum_test
}  // namespace weir::condition
