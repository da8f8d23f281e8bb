// Compares layers of a pyramid by `area` with the formulas and with the same plans run alone.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include <random>
#include <string>

#include "core/preprocess/plan_reference_test_support.hpp"
#include "core/preprocess/runner.hpp"
#include "core/transform/transform_test_support.hpp"

namespace weir::preprocess {
namespace plan_pyramid_test {

using testing::Pixels;
using transform::test::for_each_target;

Preparation of_area(const Pixels& pixels, uint32_t width, uint32_t height) {
  Preparation p;
  p.source = pixels.picture;
  p.width = width;
  p.height = height;
  p.type = ElementType::Float32;
  p.resize = Resize::Area;
  return p;
}

// One job for each plan, writing to the tensor of the same index.
std::vector<Job> jobs_of(const std::vector<PreprocessPlan>& plans,
                         std::vector<std::vector<float>>* out) {
  std::vector<Job> jobs;
  for (size_t i = 0; i < plans.size(); ++i)
    jobs.push_back({&plans[i], std::as_writable_bytes(std::span((*out)[i]))});
  return jobs;
}

TEST(PlanPyramid, IsExactForTallPictures) {
  for (const char* format : {"GRAY8", "NV12"}) {
    const Pixels pixels(format, 64, 1024, 3);
    for (const auto& [width, height] : {std::pair{16u, 4u}, {4u, 4u}, {2u, 3u}, {1u, 1u}}) {
      const auto p = of_area(pixels, width, height);
      const auto wanted = testing::reference(p, pixels);
      for_each_target([&] {
        const auto out = testing::run<float>(p, pixels);
        for (size_t i = 0; i < out.size(); ++i)
          ASSERT_NEAR(double{out[i]}, wanted[i], 1.0 / 256) << width << "x" << height;
      });
    }
  }
}

TEST(PlanPyramid, WholeSamplesAgreeWithTheFormulas) {
  for (const char* format : {"GRAY8", "RGB", "NV12", "I420", "UYVY"})
    for (const uint32_t height : {21u, 32u, 64u}) {
      Pixels pixels(format, 384, height, 5, 3);
      const double max = pixels.picture.format.model == ColorModel::Yuv ? 1.0 / 16 : 1.0 / 64;
      for (const uint32_t width : {96u, 48u, 12u, 2u, 1u})
        for (const bool second : {false, true}) {
          pixels.picture.cosited_columns = second;
          auto p = of_area(pixels, width, 8);
          if (second && width < 96) p.crop = Rect{96, 3, 288, 17};
          const auto wanted = testing::reference(p, pixels);
          for_each_target([&] {
            const auto out = testing::run<float>(p, pixels);
            ASSERT_EQ(out.size(), wanted.size());
            for (size_t i = 0; i < out.size(); ++i)
              ASSERT_NEAR(double{out[i]}, wanted[i], max)
                  << format << " to " << width << ", element " << i;
          });
        }
    }
}

// Layers of random sizes and parts of the picture that change from frame to frame, common or
// separate: the results equal those of new plans run alone, and the formulas.
TEST(PlanPyramid, RandomLayersAndPartsOfPicturesAgree) {
  for (uint32_t seed = 1; seed <= 15; ++seed) {
    std::mt19937 random(seed);
    const auto any = [&](uint32_t from, uint32_t to) {
      return from + static_cast<uint32_t>(random() % (to - from + 1));
    };
    const char* const formats[] = {"GRAY8", "NV12", "I420", "RGB", "RGBA", "YUY2", "UYVY", "NV21"};
    const uint32_t width = any(4, 40) * 8, height = any(1, 150);
    Pixels pixels(formats[seed % 5], width, height, seed, any(0, 9));
    pixels.picture.cosited_columns = any(0, 1);
    pixels.picture.cosited_rows = any(0, 1);
    std::vector<Preparation> layers;
    std::vector<PreprocessPlan> plans;
    std::vector<std::vector<float>> out;
    for (uint32_t left = any(1, 4); left > 0; --left) {
      const uint32_t factor = 2u << any(0, 5);
      layers.push_back(of_area(pixels, std::max(1u, any(0, 3) > 0 ? width / factor : any(1, 20)),
                               std::max(1u, any(0, 1) > 0 ? height / factor : any(1, 20))));
      plans.push_back(*PreprocessPlan::make(layers.back()));
      out.emplace_back(layers.back().channels() * layers.back().width * layers.back().height);
    }
    const auto jobs = jobs_of(plans, &out);
    // Pixels of some layer often are whole numbers of samples.
    const auto some_part = [&]() -> Rect {
      const uint32_t x = any(0, width / 16) * 4, y = any(0, height - 1);
      const uint32_t whole = layers[any(0, 99) % layers.size()].width << any(1, 5);
      const uint32_t max = width - x;
      return {x, y, any(0, 2) > 0 && whole <= max ? whole : any(1, max), any(1, height - y)};
    };
    Runner runner(any(1, 3));
    for (int frame = 0; frame < 4; ++frame) {
      const bool each = any(0, 3) == 0;
      Rect part{0, 0, width, height};
      for (size_t i = 0; i < plans.size() && frame > 0; ++i) {
        if (i == 0 || each) part = some_part();
        layers[i].crop = part;
        ASSERT_TRUE(plans[i].set_crop(part));
      }
      ASSERT_TRUE(runner.run(pixels.planes, jobs));
      for (size_t i = 0; i < layers.size(); ++i) {
        SCOPED_TRACE("seed " + std::to_string(seed) + ", frame " + std::to_string(frame) +
                     ", layer " + std::to_string(i));
        ASSERT_EQ(out[i], testing::run<float>(layers[i], pixels));
        const auto wanted = testing::reference(layers[i], pixels);
        for (size_t k = 0; k < wanted.size(); ++k)
          ASSERT_NEAR(double{out[i][k]}, wanted[k], 1.0 / 16) << "element " << k;
      }
    }
  }
}

}  // namespace plan_pyramid_test
}  // namespace weir::preprocess
