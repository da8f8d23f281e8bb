// Compares rows with bytes that are mixed by the formula in real numbers.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/draw/tint_row.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace weir::draw {
namespace tint_row_test {

// (d * (255 - a) + p * a) / 255 is never halfway between integers: 255 is odd.
uint8_t expected(uint8_t d, uint8_t p, uint8_t a) {
  return static_cast<uint8_t>(
      std::floor((d * (255. - a) + p * static_cast<double>(a)) / 255 + 0.5));
}

TEST(TintRow, MixesAnyNumberOfBytesAndNoOthers) {
  std::mt19937 random(3);
  Pattern pattern;
  for (size_t i = 0; i < kPatternBytes; ++i)
    pattern[i] = i < kPatternPeriod ? static_cast<uint8_t>(random()) : pattern[i - kPatternPeriod];
  for (size_t bytes = 0; bytes < 450; ++bytes) {
    const auto opacity = static_cast<uint8_t>(random());
    std::vector<uint8_t> row(bytes + 66);
    for (auto& byte : row) byte = static_cast<uint8_t>(random());
    const auto before = row;
    const size_t begin = bytes % 3;  // any alignment
    tint_row(reinterpret_cast<std::byte*>(row.data()) + begin, opacity, bytes, pattern);
    for (size_t i = 0; i < row.size(); ++i) {
      const bool is_in = i >= begin && i < begin + bytes;
      ASSERT_EQ(row[i], is_in ? expected(before[i], pattern[(i - begin) % kPatternBytes], opacity)
                              : before[i])
          << i << " of " << bytes << " with " << int{opacity};
    }
  }
}

TEST(TintRow, RoundsEachValueToTheNearest) {
  for (int opacity = 0; opacity < 256; ++opacity)
    for (int color = 0; color < 256; color += 5) {
      Pattern pattern;
      pattern.fill(static_cast<uint8_t>(color));
      std::vector<uint8_t> row(256);
      for (size_t i = 0; i < row.size(); ++i) row[i] = static_cast<uint8_t>(i);
      tint_row(reinterpret_cast<std::byte*>(row.data()), static_cast<uint8_t>(opacity), 256,
               pattern);
      for (size_t i = 0; i < row.size(); ++i)
        ASSERT_EQ(row[i], expected(static_cast<uint8_t>(i), static_cast<uint8_t>(color),
                                   static_cast<uint8_t>(opacity)));
    }
}

}  // namespace tint_row_test
}  // namespace weir::draw
