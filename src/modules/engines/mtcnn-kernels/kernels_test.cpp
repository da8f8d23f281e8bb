// Tests each kernel on each target of this CPU against a loop over doubles.
// SPDX-License-Identifier: LGPL-2.1-or-later
#define HWY_WANT_AVX3_DL
#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <cmath>
#include <random>
#include <vector>

#include "byte_kernels.hpp"

namespace mtcnn::kernels {
namespace kernels_test {

template <class F>
void for_each_target(F&& f) {
  for (const auto target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    SCOPED_TRACE(hwy::TargetName(target));
    f();
  }
  hwy::SetSupportedTargetsForTest(0);
}

std::vector<float> some(size_t count, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> uniform(-1, 1);
  std::vector<float> out(count);
  for (auto& number : out) number = uniform(random);
  return out;
}
template <class T>
std::vector<T> some_bytes(size_t count, uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<T> out(count);
  for (auto& number : out) number = static_cast<T>(random());
  return out;
}

double prelu(double x, double slope) {
  return x < 0 ? slope * x : x;
}

struct Shape {
  size_t height, run, in_step, outputs, pixels;
};
// The layers of the networks, and odd shapes.
const Shape kShapes[] = {{3, 9, 3, 10, 31},    {3, 30, 10, 16, 25},   {3, 48, 16, 32, 13},
                         {1, 32, 32, 6, 12},   {3, 9, 3, 28, 22},     {3, 84, 28, 48, 9},
                         {2, 96, 48, 64, 3},   {1, 576, 576, 128, 7}, {2, 128, 64, 128, 3},
                         {1, 1, 1, 1, 1},      {2, 5, 7, 17, 2},      {3, 3, 1, 33, 11},
                         {1, 256, 256, 16, 1}, {2, 7, 5, 96, 5}};

TEST(FloatKernels, ConvolutionAgreesWithAPlainLoop) {
  for_each_target([] {
    for (const Shape& s : kShapes) {
      SCOPED_TRACE(std::to_string(s.run) + " x " + std::to_string(s.outputs));
      const size_t stride = padded(s.outputs), length = s.pixels * s.in_step + s.run;
      const auto in = some(3 * length, 1), weights = some(s.height * s.run * stride, 2);
      const auto bias = some(stride, 3), slope = some(stride, 4);
      std::vector<float> out(s.pixels * stride + 1, 77.f);
      ConvolveRow row{{&in[0], &in[length], &in[2 * length]},
                      s.height,
                      s.run,
                      s.in_step,
                      weights.data(),
                      bias.data(),
                      slope.data(),
                      s.outputs,
                      out.data(),
                      s.pixels};
      convolve(row);
      for (size_t p = 0; p < s.pixels; ++p)
        for (size_t o = 0; o < stride; ++o) {
          double sum = bias[o];
          for (size_t r = 0; r < s.height; ++r)
            for (size_t k = 0; k < s.run; ++k)
              sum += double{row.rows[r][p * s.in_step + k]} * weights[(r * s.run + k) * stride + o];
          ASSERT_NEAR(out[p * stride + o], prelu(sum, slope[o]), 2e-4) << p << ", " << o;
        }
      EXPECT_EQ(out.back(), 77.f) << "nothing is written after the row";
    }
  });
}

TEST(ByteKernels, ConvolutionAgreesWithAPlainLoop) {
  for_each_target([] {
    for (const Shape& s : kShapes) {
      SCOPED_TRACE(std::to_string(s.run) + " x " + std::to_string(s.outputs));
      const size_t quads = (s.run + 3) / 4, stride = padded(s.outputs);
      const size_t length = s.pixels * s.in_step + 4 * quads;
      const auto in = some_bytes<uint8_t>(3 * length, 1);
      const auto weights = some_bytes<int8_t>(s.height * quads * 4 * stride, 2);
      const auto bias = some(stride, 3), slope = some(stride, 4);
      const std::vector<float> scale(stride, 0.001f);
      std::vector<float> numbers(s.pixels * stride + 1, 77.f);
      std::vector<uint8_t> bytes(s.pixels * stride + 1, 77);
      ConvolveByteRow row{{&in[0], &in[length], &in[2 * length]},
                          s.height,
                          quads,
                          s.in_step,
                          weights.data(),
                          scale.data(),
                          bias.data(),
                          slope.data(),
                          s.outputs,
                          numbers.data(),
                          nullptr,
                          100.f,
                          s.pixels};
      convolve(row);
      row.numbers = nullptr;
      row.bytes = bytes.data();
      convolve(row);
      for (size_t p = 0; p < s.pixels; ++p)
        for (size_t o = 0; o < stride; ++o) {
          int64_t sum = 0;
          for (size_t r = 0; r < s.height; ++r)
            for (size_t k = 0; k < 4 * quads; ++k)
              sum += int64_t{row.rows[r][p * s.in_step + k]} *
                     weights[((r * quads + k / 4) * stride + o) * 4 + k % 4];
          const double wanted = prelu(static_cast<double>(sum) * 0.001f + bias[o], slope[o]);
          ASSERT_NEAR(numbers[p * stride + o], wanted, 1e-3) << p << ", " << o;
          ASSERT_NEAR(bytes[p * stride + o], std::clamp(wanted + 100, 0.0, 255.0), 0.502)
              << p << ", " << o;
        }
      EXPECT_EQ(numbers.back(), 77.f);
      EXPECT_EQ(bytes.back(), 77);
    }
  });
}

// Kernels of 2 and 3 over odd and even numbers of rows, with and without a missing last row.
template <class Number>
void pools_like_a_plain_loop(const std::vector<Number>& in) {
  for_each_target([&] {
    for (const size_t kernel : {2, 3})
      for (const size_t height : {kernel, kernel - 1})
        for (const size_t channels : {10, 12, 28, 32, 48})
          for (const size_t pixels : {1, 2, 3, 4, 7, 22}) {
            const size_t in_step = padded(channels), length = pixels * in_step + kRowMargin;
            const size_t wanted = pixels <= kernel ? 1 : (pixels - kernel + 1) / 2 + 1;
            std::vector<Number> out(wanted * channels + kRowMargin);
            PoolRow<Number> row{{&in[0], &in[length], &in[2 * length]},
                                height,
                                kernel,
                                channels,
                                in_step,
                                channels,
                                pixels,
                                wanted,
                                out.data()};
            pool(row);
            for (size_t p = 0; p < wanted; ++p)
              for (size_t c = 0; c < channels; ++c) {
                Number max = row.rows[0][2 * p * in_step + c];
                for (size_t r = 0; r < height; ++r)
                  for (size_t x = 2 * p; x < std::min(2 * p + kernel, pixels); ++x)
                    max = std::max(max, row.rows[r][x * in_step + c]);
                ASSERT_EQ(out[p * channels + c], max) << kernel << ", " << pixels << ", " << c;
              }
          }
  });
}

TEST(FloatKernels, PoolingAgreesWithAPlainLoop) {
  pools_like_a_plain_loop(some(3 * (22 * 48 + kRowMargin), 5));
}
TEST(ByteKernels, PoolingAgreesWithAPlainLoop) {
  pools_like_a_plain_loop(some_bytes<uint8_t>(3 * (22 * 48 + kRowMargin), 5));
}

TEST(FloatKernels, BytesAreConvertedToTheSameNumbers) {
  for_each_target([] {
    for (const size_t count : {0, 1, 15, 16, 17, 100}) {
      const auto in = some_bytes<uint8_t>(count, 6);
      std::vector<float> out(count + 1, -1.f);
      widen(in.data(), count, out.data());
      for (size_t i = 0; i < count; ++i) ASSERT_EQ(out[i], in[i]);
      EXPECT_EQ(out.back(), -1.f);
    }
  });
}

}  // namespace kernels_test
}  // namespace mtcnn::kernels
