// Compares resizing with OpenCV's resize(), as preparation.hpp promises.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "core/preprocess/plan_reference_test_support.hpp"

namespace weir::preprocess {
namespace opencv_test {

using testing::Pixels;
using testing::run;

struct Case {
  const char* name;
  Resize ours;
  int theirs;
  bool shrinks_only;  // when enlarging, OpenCV's area is a different method
};
constexpr Case kCases[] = {{"nearest", Resize::Nearest, cv::INTER_NEAREST, false},
                           {"bilinear", Resize::Bilinear, cv::INTER_LINEAR, false},
                           {"area", Resize::Area, cv::INTER_AREA, true}};
constexpr std::pair<int, int> kSizes[] = {{24, 24}, {16, 9}, {31, 20}, {64, 48},
                                          {7, 45},  {1, 1},  {96, 50}, {128, 96}};
constexpr int kWidth = 64, kHeight = 48;

// Resizes the same random picture with both; `Value` is the element type.
template <class Value>
void compare(const Case& c, int width, int height, double max) {
  SCOPED_TRACE(std::string(c.name) + " to " + std::to_string(width) + "x" + std::to_string(height));
  constexpr bool kBytes = std::is_same_v<Value, uint8_t>;
  Pixels pixels("RGB", kWidth, kHeight, static_cast<uint32_t>(width * 1000 + height), 5);
  Preparation p;
  p.source = pixels.picture;
  p.width = static_cast<uint32_t>(width);
  p.height = static_cast<uint32_t>(height);
  p.resize = c.ours;
  p.type = kBytes ? ElementType::UInt8 : ElementType::Float32;
  const auto ours = run<Value>(p, pixels);

  const Plane& plane = pixels.planes[0];
  cv::Mat picture(kHeight, kWidth, CV_8UC3, pixels.memory.data() + plane.offset,
                  static_cast<size_t>(plane.stride));
  if (!kBytes) picture.convertTo(picture, CV_32F);
  cv::Mat theirs;
  cv::setNumThreads(1);  // OpenCV's threads are not under test
  cv::resize(picture, theirs, {width, height}, 0, 0, c.theirs);
  ASSERT_TRUE(theirs.isContinuous());
  ASSERT_EQ(ours.size(), theirs.total() * 3);
  const auto* const wanted = theirs.ptr<Value>();
  for (size_t i = 0; i < ours.size(); ++i)
    ASSERT_NEAR(static_cast<double>(ours[i]), static_cast<double>(wanted[i]), max)
        << "element " << i;
}

TEST(OpenCv, BytesAreAtMostOneStepApart) {
  for (const auto& c : kCases)
    for (const auto& [width, height] : kSizes)
      if (!c.shrinks_only || (width <= kWidth && height <= kHeight))
        compare<uint8_t>(c, width, height, c.ours == Resize::Nearest ? 0 : 1);
}

TEST(OpenCv, FloatsAreThoseOfTheFormulas) {
  for (const auto& c : kCases)
    for (const auto& [width, height] : kSizes)
      if (!c.shrinks_only || (width <= kWidth && height <= kHeight))
        compare<float>(c, width, height, c.ours == Resize::Nearest ? 0.001 : 1.0 / 32);
}

}  // namespace opencv_test
}  // namespace weir::preprocess
