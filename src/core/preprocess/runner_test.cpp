// The same numbers from any number of threads.
#include "core/preprocess/runner.hpp"

#include <gtest/gtest.h>

#include "core/preprocess/plan_reference.hpp"

namespace weir::preprocess {
namespace {

using testing::Pixels;

Preparation preparation(const Pixels& pixels, uint32_t width, uint32_t height) {
  Preparation p;
  p.source = pixels.picture;
  p.width = width;
  p.height = height;
  p.fit = Fit::Letterbox;
  return p;
}

TEST(Runner, GivesTheSameFromAnyNumberOfThreads) {
  const Pixels pixels("NV12", 40, 30, 3);
  for (const uint32_t height : {1u, 2u, 7u, 64u}) {
    const auto p = preparation(pixels, 33, height);
    const auto wanted = testing::run<uint8_t>(p, pixels);
    ASSERT_FALSE(wanted.empty());
    for (const size_t threads : {0u, 1u, 2u, 3u, 5u}) {
      Runner runner(*Plan::make(p), threads);
      for (int frame = 0; frame < 50; ++frame) {
        std::vector<uint8_t> out(wanted.size());
        ASSERT_TRUE(runner.run(pixels.planes, std::as_writable_bytes(std::span(out))));
        ASSERT_EQ(out, wanted) << threads << " threads";
      }
    }
  }
}

TEST(Runner, TakesAnotherPlan) {
  const Pixels pixels("RGB", 40, 30), other("I420", 90, 50);
  Runner runner(*Plan::make(preparation(pixels, 8, 9)), 3);
  const auto p = preparation(other, 70, 41);
  runner.set_plan(*Plan::make(p));
  std::vector<uint8_t> out(size_t{3} * 70 * 41);
  ASSERT_TRUE(runner.run(other.planes, std::as_writable_bytes(std::span(out))));
  EXPECT_EQ(out, testing::run<uint8_t>(p, other));
}

TEST(Runner, TellsAnErrorOnceAndGoesOn) {
  const Pixels pixels("RGB", 40, 30);
  for (const size_t threads : {1u, 4u}) {
    Runner runner(*Plan::make(preparation(pixels, 8, 8)), threads);
    std::vector<std::byte> out(3 * 8 * 8);
    auto planes = pixels.planes;
    planes[0].memory = planes[0].memory.first(100);
    const auto status = runner.run(planes, out);
    ASSERT_FALSE(status);
    EXPECT_NE(status.error().message().find("plane 0 of 100 bytes"), std::string::npos);
    EXPECT_TRUE(runner.run(pixels.planes, out));
  }
}

}  // namespace
}  // namespace weir::preprocess
