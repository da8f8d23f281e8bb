// Compares weighted samples of a row with a plain loop. All numbers are small multiples of 1/8, so
// sums are exact in any order.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "core/preprocess/row_kernels.hpp"
#include "core/preprocess/tap_kernels.hpp"
#include "core/transform/transform_test_support.hpp"

namespace weir::preprocess {
namespace tap_kernels_test {

using transform::test::for_each_target;

struct Taps {
  size_t count, taps, stride;
  std::vector<int32_t> index;
  std::vector<float> weights, in;

  // Samples of `factor` adjacent pixels, in steps of `factor` pixels with `step` components each.
  Taps(size_t targets, size_t of, double factor, size_t step, uint32_t seed)
      : count(targets),
        taps(of),
        stride(padded(targets)),
        index(stride * of),
        weights(stride * of) {
    std::mt19937 random(seed);
    for (size_t k = 0; k < taps; ++k)
      for (size_t i = 0; i < stride; ++i) {
        const size_t target = std::min(i, count - 1);
        index[k * stride + i] = static_cast<int32_t>(
            (static_cast<size_t>(static_cast<double>(target) * factor) + k) * step);
        weights[k * stride + i] = static_cast<float>(random() % 8) / 8;
      }
    in.resize(static_cast<size_t>(index.back()) + step);
    for (float& number : in) number = static_cast<float>(random() % 256);
  }

  float plain(size_t target, size_t component) const {
    float sum = 0;
    for (size_t k = 0; k < taps; ++k) {
      const size_t at = k * stride + target;
      sum += weights[at] * in[static_cast<size_t>(index[at]) + component];
    }
    return sum;
  }
};

// Of samples to targets.
constexpr double kFactors[] = {0, 0.3, 0.9, 1, 1.5, 2, 2.7, 3, 3.9, 4.2, 9};
constexpr size_t kCounts[] = {1, 7, 16, 33, 100};

TEST(TapKernels, TakesEachComponentOfInterleavedPixels) {
  for (const size_t step : {1u, 2u, 3u, 4u})
    for (const double factor : kFactors)
      for (const size_t count : kCounts)
        for (const size_t taps : {1u, 2u, 5u}) {
          const Taps of(count, taps, factor, step, 5);
          for_each_target([&] {
            for (size_t l = 0; l < step; ++l) {
              std::vector<float> out(of.stride, -1);
              gather_row(of.in.data() + l, of.index.data(), of.weights.data(), taps, count,
                         out.data());
              for (size_t i = 0; i < count; ++i)
                ASSERT_EQ(out[i], of.plain(i, l))
                    << "component " << l << " of " << step << ", target " << i << " of " << count
                    << ", factor " << factor << ", taps " << taps;
            }
          });
        }
}

}  // namespace tap_kernels_test
}  // namespace weir::preprocess
