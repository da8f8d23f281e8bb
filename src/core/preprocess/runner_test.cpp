// The numbers do not depend on the number of threads.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/preprocess/runner.hpp"

#include <gtest/gtest.h>

#include "core/preprocess/plan_reference_test_support.hpp"
#include "says.hpp"

namespace weir::preprocess {
namespace runner_test {

using testing::Pixels;

Preparation preparation(const Pixels& pixels, uint32_t width, uint32_t height) {
  Preparation p;
  p.source = pixels.picture;
  p.width = width;
  p.height = height;
  p.fit = Fit::Letterbox;
  return p;
}

Status run(Runner* runner, const PreprocessPlan& plan, const Planes& planes,
           std::span<std::byte> out) {
  const Job job{&plan, out};
  return runner->run(planes, {&job, 1});
}

TEST(Runner, GivesTheSameFromAnyNumberOfThreads) {
  const Pixels pixels("NV12", 40, 30, 3);
  for (const uint32_t height : {1u, 2u, 7u, 64u}) {
    const auto p = preparation(pixels, 33, height);
    const auto wanted = testing::run<uint8_t>(p, pixels);
    ASSERT_FALSE(wanted.empty());
    for (const size_t threads : {0u, 1u, 2u, 3u, 5u}) {
      const PreprocessPlan plan = *PreprocessPlan::make(p);
      Runner runner(threads);
      for (int frame = 0; frame < 50; ++frame) {
        std::vector<uint8_t> out(wanted.size());
        ASSERT_TRUE(run(&runner, plan, pixels.planes, std::as_writable_bytes(std::span(out))));
        ASSERT_EQ(out, wanted) << threads << " threads";
      }
    }
  }
}

// The last vector of a row is written twice; it must not reach the next thread's row.
TEST(Runner, WritesAdjacentFloats) {
  const Pixels pixels("I420", 90, 50, 2);
  for (const Layout layout : {Layout::Nchw, Layout::Nhwc}) {
    auto p = preparation(pixels, 37, 64);
    p.fit = Fit::Stretch;
    p.type = ElementType::Float32;
    p.layout = layout;
    const auto wanted = testing::run<float>(p, pixels);
    ASSERT_FALSE(wanted.empty());
    const PreprocessPlan plan = *PreprocessPlan::make(p);
    Runner runner(4);
    for (int frame = 0; frame < 50; ++frame) {
      std::vector<float> out(wanted.size());
      ASSERT_TRUE(run(&runner, plan, pixels.planes, std::as_writable_bytes(std::span(out))));
      ASSERT_EQ(out, wanted);
    }
  }
}

// 17 MB of tensors exceed the caches.
TEST(Runner, UsesStreamingStoresForLargeTensors) {
  const Pixels pixels("NV12", 64, 48, 2);
  auto p = preparation(pixels, 1201, 1201);
  p.type = ElementType::Float32;
  p.layout = Layout::Nchw;
  const auto wanted = testing::run<float>(p, pixels);
  ASSERT_GE(wanted.size() * sizeof(float), size_t{16} << 20);
  for (const size_t threads : {1u, 3u}) {
    const PreprocessPlan plan = *PreprocessPlan::make(p);
    Runner runner(threads);
    std::vector<float> out(wanted.size());
    ASSERT_TRUE(run(&runner, plan, pixels.planes, std::as_writable_bytes(std::span(out))));
    EXPECT_TRUE(out == wanted) << threads << " threads";
  }
}

TEST(Runner, AcceptsPicturesOfADifferentFormat) {
  Runner runner(1);
  for (const char* format : {"GRAY8", "RGBx", "NV12", "RGB"}) {
    const Pixels pixels(format, 16, 16, 0, 3);
    auto p = preparation(pixels, 4, 4);
    p.resize = Resize::Area;
    const auto wanted = testing::run<uint8_t>(p, pixels);
    std::vector<uint8_t> out(wanted.size());
    ASSERT_TRUE(run(&runner, *PreprocessPlan::make(p), pixels.planes,
                    std::as_writable_bytes(std::span(out))));
    EXPECT_EQ(out, wanted) << format;
  }
}

TEST(Runner, RunsSeveralPlansOverOnePicture) {
  const Pixels pixels("NV12", 90, 50, 2);
  std::vector<PreprocessPlan> plans;
  std::vector<std::vector<uint8_t>> out, wanted;
  for (const uint32_t side : {70u, 8u, 1u}) {
    plans.push_back(*PreprocessPlan::make(preparation(pixels, side, side + 1)));
    wanted.push_back(testing::run<uint8_t>(plans.back().preparation(), pixels));
  }
  for (const size_t threads : {1u, 3u}) {
    Runner runner(threads);
    out = {};
    std::vector<Job> jobs;
    for (const auto& one : wanted) out.emplace_back(one.size());
    for (size_t i = 0; i < 3; ++i)
      jobs.push_back({&plans[i], std::as_writable_bytes(std::span(out[i]))});
    ASSERT_TRUE(runner.run(pixels.planes, jobs));
    EXPECT_EQ(out, wanted);
    // A job that fails leaves all tensors unchanged.
    for (auto& one : out) one.assign(one.size(), 1);
    const auto untouched = out;
    jobs[2].out = jobs[2].out.first(1);
    EXPECT_FALSE(runner.run(pixels.planes, jobs));
    EXPECT_EQ(out, untouched);
  }
}

TEST(Runner, ReportsAnErrorOnceAndContinues) {
  const Pixels pixels("RGB", 40, 30);
  for (const size_t threads : {1u, 4u}) {
    const PreprocessPlan plan = *PreprocessPlan::make(preparation(pixels, 8, 8));
    Runner runner(threads);
    std::vector<std::byte> out(3 * 8 * 8);
    auto planes = pixels.planes;
    planes[0].memory = planes[0].memory.first(100);
    const auto status = run(&runner, plan, planes, out);
    ASSERT_FALSE(status);
    EXPECT_SAYS(status.error().message(), "plane 0 of 100 bytes");
    EXPECT_TRUE(run(&runner, plan, pixels.planes, out));
  }
}

}  // namespace runner_test
}  // namespace weir::preprocess
