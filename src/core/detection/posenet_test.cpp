// Tests of PoseNet's persons: maps are encoded from key points as PersonLab describes.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/detection/posenet.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

namespace weir::detection {
namespace posenet_test {

constexpr size_t kWidth = 40, kHeight = 30;
constexpr float kStride = 16;

// Parent and child of each edge, by name: nose 0, eyes 1 2, ears 3 4, shoulders 5 6, elbows 7 8,
// wrists 9 10, hips 11 12, knees 13 14, ankles 15 16.
constexpr size_t kSkeleton[16][2]{{0, 1},  {1, 3},  {0, 2},   {2, 4},   {0, 5}, {5, 7},
                                  {7, 9},  {5, 11}, {11, 13}, {13, 15}, {0, 6}, {6, 8},
                                  {8, 10}, {6, 12}, {12, 14}, {14, 16}};

using Pose = std::vector<std::pair<float, float>>;  // x, y of 17 points

// A body upright around x, y.
Pose body(float x, float y) {
  return {{x, y},
          {x + 8, y - 8},
          {x - 8, y - 8},
          {x + 18, y - 4},
          {x - 18, y - 4},
          {x + 40, y + 50},
          {x - 40, y + 50},
          {x + 60, y + 110},
          {x - 55, y + 115},
          {x + 70, y + 170},
          {x - 75, y + 160},
          {x + 25, y + 180},
          {x - 25, y + 180},
          {x + 30, y + 260},
          {x - 28, y + 255},
          {x + 33, y + 330},
          {x - 31, y + 340}};
}

struct Encoded {
  std::vector<float> heat = std::vector<float>(kWidth * kHeight * 17, -6.0f);
  std::vector<float> offsets = std::vector<float>(kWidth * kHeight * 34);
  std::vector<float> vectors = std::vector<float>(kWidth * kHeight * 64);

  PoseNetMaps maps() const {
    return {.width = kWidth,
            .height = kHeight,
            .stride_x = kStride,
            .stride_y = kStride,
            .heat = heat,
            .offsets = offsets,
            .forward = {.values = vectors, .per_cell = 64, .y = 0, .x = 16},
            .backward = {.values = vectors, .per_cell = 64, .y = 32, .x = 48}};
  }
  // Discs of 2 cells around each point.
  void add(const Pose& pose, float logit, size_t first_hidden = 17) {
    for (size_t point = 0; point < 17; ++point) {
      const auto [px, py] = pose[point];
      for (size_t y = 0; y < kHeight; ++y)
        for (size_t x = 0; x < kWidth; ++x) {
          const float dx = px - static_cast<float>(x) * kStride,
                      dy = py - static_cast<float>(y) * kStride;
          if (std::hypot(dx, dy) > 2 * kStride) continue;
          const size_t cell = y * kWidth + x;
          const float value = logit - std::hypot(dx, dy) / kStride;
          if (point >= first_hidden || value <= heat[cell * 17 + point]) continue;
          heat[cell * 17 + point] = value;
          offsets[cell * 34 + point] = dy;
          offsets[cell * 34 + 17 + point] = dx;
          for (size_t edge = 0; edge < 16; ++edge) {
            const auto& [parent, child] = kSkeleton[edge];
            if (parent == point) {
              vectors[cell * 64 + edge] = pose[child].second - py;
              vectors[cell * 64 + 16 + edge] = pose[child].first - px;
            }
            if (child == point) {
              vectors[cell * 64 + 32 + edge] = pose[parent].second - py;
              vectors[cell * 64 + 48 + edge] = pose[parent].first - px;
            }
          }
        }
    }
  }
};

void expect_pose(const PoseNetPerson& person, const Pose& pose) {
  for (size_t point = 0; point < 17; ++point) {
    EXPECT_NEAR(person.points[point].x, pose[point].first, 0.01) << point;
    EXPECT_NEAR(person.points[point].y, pose[point].second, 0.01) << point;
  }
}

TEST(PoseNet, FindsEachOfSeveralPersons) {
  const Pose left = body(120, 70), middle = body(330, 60), right = body(530, 90);
  Encoded encoded;
  encoded.add(left, 3);
  encoded.add(middle, 5);
  encoded.add(right, 4);
  const auto people = find_people(encoded.maps(), 0.25f);
  ASSERT_EQ(people.size(), 3u);
  expect_pose(people[0], middle);
  expect_pose(people[1], right);
  expect_pose(people[2], left);
  EXPECT_GT(people[0].score, 0.9);
}

TEST(PoseNet, APersonMayStartFromAnyPoint) {
  for (size_t point = 0; point < 17; ++point) {
    const Pose pose = body(330, 60);
    Encoded encoded;
    encoded.add(pose, 1);
    // This point is the surest one.
    for (size_t cell = 0; cell < kWidth * kHeight; ++cell) encoded.heat[cell * 17 + point] += 3;
    const auto people = find_people(encoded.maps(), 0.25f);
    ASSERT_EQ(people.size(), 1u) << point;
    expect_pose(people[0], pose);
  }
}

TEST(PoseNet, TheBestPersonHasTheBestPoints) {
  const Pose pose = body(330, 60);
  Encoded encoded;
  encoded.add(body(120, 70), 3);
  encoded.add(pose, 5);
  const auto person = best_person(encoded.maps());
  expect_pose(person, pose);
  float sum = 0;
  for (const auto& point : person.points) sum += point.score;
  EXPECT_NEAR(person.score, sum / 17, 1e-5);
}

TEST(PoseNet, WeakPersonsAreLeftOut) {
  Encoded encoded;
  encoded.add(body(330, 60), 5, 5);  // only the face is visible: 5 of 17 points
  EXPECT_EQ(find_people(encoded.maps(), 0.2f).size(), 1u);
  EXPECT_EQ(find_people(encoded.maps(), 0.4f).size(), 0u);
}

TEST(PoseNet, EmptyMapsHaveNoPerson) {
  EXPECT_TRUE(find_people(Encoded().maps(), 0).empty());
}

TEST(PoseNet, MapsWithoutMeaningEnd) {
  for (const float value : {0.0f, 10.0f, NAN, INFINITY, -INFINITY, 1e30f}) {
    Encoded encoded;
    for (auto* values : {&encoded.heat, &encoded.offsets, &encoded.vectors})
      std::fill(values->begin(), values->end(), value);
    for (const auto& person : find_people(encoded.maps(), 0.1f)) {
      EXPECT_TRUE(std::isfinite(person.score)) << value;
      EXPECT_LE(person.score, 1.001f);
    }
    EXPECT_FALSE(std::isnan(best_person(encoded.maps()).score)) << value;
  }
}

}  // namespace posenet_test
}  // namespace weir::detection
