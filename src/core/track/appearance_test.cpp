// Tests of Appearance, and of the tracker that uses it.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/track/appearance.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/track/tracker.hpp"

namespace weir::track {
namespace appearance_test {

using Vector = std::vector<float>;
using Numbers = std::vector<uint32_t>;

TEST(Appearance, DistanceIsOneMinusTheCosine) {
  Appearance a;
  a.add(Vector{3, 0});
  EXPECT_FLOAT_EQ(a.distance(Vector{5, 0}), 0);
  EXPECT_FLOAT_EQ(a.distance(Vector{1, 1}), 1 - 0.70710678f);
  EXPECT_FLOAT_EQ(a.distance(Vector{0, 9}), 1);
  EXPECT_FLOAT_EQ(a.distance(Vector{-1, 0}), 2);
}

TEST(Appearance, IsAMeanThatChangesSlowly) {
  Appearance a;
  a.add(Vector{1, 0});
  a.add(Vector{0, 1});  // 0.9, 0.1
  EXPECT_NEAR(a.distance(Vector{1, 0}), 1 - 0.9 / std::sqrt(0.82), 1e-6);
}

TEST(Appearance, VectorsWithoutADirectionAreUnknown) {
  const float inf = std::numeric_limits<float>::infinity();
  Appearance a;
  EXPECT_EQ(a.distance(Vector{1, 0}), 2);
  for (const Vector& bad : {Vector{}, Vector{0, 0}, Vector{inf, 1}, Vector{std::nanf(""), 1}}) {
    a.add(bad);
    EXPECT_EQ(a.distance(Vector{1, 0}), 2);
  }
  a.add(Vector{1, 0});
  a.add(Vector{1, 0, 0});  // another network
  EXPECT_FLOAT_EQ(a.distance(Vector{1, 0}), 0);
  EXPECT_EQ(a.distance(Vector{1, 0, 0}), 2);
  EXPECT_EQ(a.distance(Vector{0, inf}), 2);
}

Observation at(float x, const Vector& looks) {
  return {{x, 0, x + 40, 80}, 0.9f, 0, looks};
}

// Two objects stand close together and change places from one frame to the next.
Numbers after_a_change_of_places(const Vector& one, const Vector& other) {
  Tracker tracker;
  const Options options{.min_hits = 1};
  for (int i = 0; i < 10; ++i)
    tracker.follow(std::vector<Observation>{at(100, one), at(112, other)}, i / 30.0, options);
  return tracker.follow(std::vector<Observation>{at(102, other), at(110, one)}, 0.33, options);
}

TEST(Tracker, AppearanceSeparatesObjectsThatChangedPlaces) {
  EXPECT_EQ(after_a_change_of_places({1, 0}, {0, 1}), (Numbers{2, 1}));
  EXPECT_EQ(after_a_change_of_places({}, {}), (Numbers{1, 2}));
}

TEST(Tracker, AppearanceFindsALostObjectThatItsBoxDoesNotOverlap) {
  for (const bool is_same : {true, false}) {
    Tracker tracker;
    const Options options{.min_hits = 1};
    const Vector looks{1, 0}, others{0, 1};
    for (int i = 0; i < 10; ++i)
      tracker.follow(std::vector<Observation>{at(100, looks)}, i / 30.0, options);
    const auto found = std::vector<Observation>{at(145, is_same ? looks : others)};
    EXPECT_EQ(tracker.follow(found, 1.0, options), Numbers{is_same ? 1u : 2u});
    const auto far = std::vector<Observation>{at(2000, looks)};  // beyond the gate of the motion
    EXPECT_EQ(tracker.follow(far, 1.03, options), Numbers{is_same ? 2u : 3u});
  }
}

}  // namespace appearance_test
}  // namespace weir::track
