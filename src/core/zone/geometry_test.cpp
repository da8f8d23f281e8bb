// Tests of points in polygons, crossed lines and homographies.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/zone/geometry.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

namespace weir::zone {
namespace geometry_test {

using Points = std::vector<Point>;
const Points kSquare{{10, 10}, {20, 10}, {20, 20}, {10, 20}};

TEST(Contains, TheInnerPartOfASquare) {
  EXPECT_TRUE(contains(kSquare, {15, 15}));
  for (const Point& out : Points{{5, 15}, {25, 15}, {15, 5}, {15, 25}, {-1e9, 15}, {1e300, 15}})
    EXPECT_FALSE(contains(kSquare, out)) << out.x << ", " << out.y;
}

TEST(Contains, EachPointOfTwoAreasThatTouchOnce) {
  const Points right{{20, 10}, {30, 10}, {30, 20}, {20, 20}};
  const Points below{{10, 20}, {20, 20}, {20, 30}, {10, 30}};
  for (double at = 10; at < 20; at += 0.5) {
    EXPECT_NE(contains(kSquare, {20, at}), contains(right, {20, at})) << at;
    EXPECT_NE(contains(kSquare, {at, 20}), contains(below, {at, 20})) << at;
  }
}

TEST(Contains, DoesNotDependOnTheFirstCornerOrTheDirection) {
  const Points arrow{{0, 0}, {10, 5}, {0, 10}, {4, 5}};
  for (double y = -1; y < 12; y += 0.37)
    for (double x = -1; x < 12; x += 0.41) {
      const Points turned{arrow[2], arrow[3], arrow[0], arrow[1]};
      const Points reversed{arrow.rbegin(), arrow.rend()};
      EXPECT_EQ(contains(arrow, {x, y}), contains(turned, {x, y}));
      EXPECT_EQ(contains(arrow, {x, y}), contains(reversed, {x, y}));
    }
  EXPECT_TRUE(contains(arrow, {6, 5}));
  EXPECT_FALSE(contains(arrow, {2, 5})) << "the notch";
}

// The pentagram's inner pentagon is covered twice.
TEST(Contains, NotWhatASelfCrossingPolygonCoversTwice) {
  Points star;
  for (int i = 0; i < 5; ++i) {
    const double angle = (0.8 * i - 0.5) * std::numbers::pi;
    star.push_back({100 * std::cos(angle), 100 * std::sin(angle)});
  }
  EXPECT_FALSE(contains(star, {0, 0}));
  for (int i = 0; i < 5; ++i) {
    const double angle = (0.4 * i - 0.5) * std::numbers::pi;
    EXPECT_TRUE(contains(star, {70 * std::cos(angle), 70 * std::sin(angle)})) << i;
    EXPECT_FALSE(contains(star, {-70 * std::cos(angle), -70 * std::sin(angle)})) << i;
  }
}

TEST(Contains, NothingInPolygonsWithoutAnArea) {
  EXPECT_FALSE(contains({}, {0, 0}));
  EXPECT_FALSE(contains(Points{{0, 0}}, {0, 0}));
  EXPECT_FALSE(contains(Points{{0, 0}, {9, 9}, {5, 5}}, {5, 5}));
  EXPECT_FALSE(contains(kSquare, {NAN, 15}));
}

TEST(Crossing, IsForwardToTheRightHandSide) {
  const Point a{0, 0}, b{10, 0};  // looking to the right: the right hand points down
  EXPECT_EQ(crossing(a, b, {5, -1}, {5, 1}), Crossing::Forward);
  EXPECT_EQ(crossing(a, b, {5, 1}, {5, -1}), Crossing::Backward);
  EXPECT_EQ(crossing(b, a, {5, -1}, {5, 1}), Crossing::Backward);
  EXPECT_EQ(crossing({0, 0}, {0, 10}, {1, 5}, {-1, 5}), Crossing::Forward);
}

TEST(Crossing, NeedsTheMoveToMeetTheSegment) {
  const Point a{0, 0}, b{10, 0};
  EXPECT_EQ(crossing(a, b, {-1, -1}, {-1, 1}), Crossing::None);
  EXPECT_EQ(crossing(a, b, {11, -1}, {11, 1}), Crossing::None);
  EXPECT_EQ(crossing(a, b, {-2, -1}, {1, 1}), Crossing::None) << "meets it at -0.5";
  EXPECT_EQ(crossing(a, b, {-1, -1}, {3, 1}), Crossing::Forward) << "meets it at 1";
  EXPECT_EQ(crossing(a, b, {5, 1}, {6, 2}), Crossing::None);
  EXPECT_EQ(crossing(a, b, {5, 1}, {5, 1}), Crossing::None);
  EXPECT_EQ(crossing(a, b, {5, NAN}, {5, 1}), Crossing::None);
}

TEST(Crossing, CountsAStopOnTheLineOnce) {
  const Point a{0, 0}, b{10, 0};
  EXPECT_EQ(crossing(a, b, {5, -1}, {5, 0}), Crossing::Forward);
  EXPECT_EQ(crossing(a, b, {5, 0}, {5, 1}), Crossing::None);
  EXPECT_EQ(crossing(a, b, {5, 1}, {5, 0}), Crossing::None);
  EXPECT_EQ(crossing(a, b, {5, 0}, {5, -1}), Crossing::Backward);
}

TEST(Crossing, CountsTheCommonEndOfTwoLinesOnce) {
  const Point from{10, -1}, to{10, 1};
  EXPECT_EQ(crossing({0, 0}, {10, 0}, from, to), Crossing::None);
  EXPECT_EQ(crossing({10, 0}, {20, 0}, from, to), Crossing::Forward);
}

TEST(Distance, IsThatToTheNearestPointOfTheLine) {
  EXPECT_DOUBLE_EQ(distance_to_line({0, 0}, {10, 0}, {4, -3}), 3);
  EXPECT_DOUBLE_EQ(distance_to_line({0, 0}, {10, 0}, {13, 4}), 5) << "beyond its end";
  EXPECT_DOUBLE_EQ(distance_to_line({0, 0}, {10, 0}, {-3, 4}), 5);
  EXPECT_DOUBLE_EQ(distance_to_line({0, 0}, {4, 3}, {4, 3}), 0);
  EXPECT_DOUBLE_EQ(distance_to_line({2, 2}, {2, 2}, {5, 6}), 5) << "a line of one point";
}

TEST(Distance, ToAnOutlineIsThatToTheNearestSide) {
  EXPECT_DOUBLE_EQ(distance_to_outline(kSquare, {11, 15}), 1);
  EXPECT_DOUBLE_EQ(distance_to_outline(kSquare, {9, 15}), 1) << "the last side";
  EXPECT_DOUBLE_EQ(distance_to_outline(kSquare, {23, 24}), 5);
  EXPECT_TRUE(std::isinf(distance_to_outline({}, {0, 0})));
}

TEST(ReferencePoint, IsOnTheBox) {
  const Box box{10, 20, 30, 60};
  const auto equal = [](Point p, double x, double y) {
    EXPECT_NEAR(p.x, x, 1e-5);
    EXPECT_NEAR(p.y, y, 1e-5);
  };
  equal(reference_point(box, 0, Reference::Bottom), 20, 60);
  equal(reference_point(box, 0, Reference::Centre), 20, 40);
  equal(reference_point(box, 0, Reference::Top), 20, 20);
  // A quarter turn clockwise: the bottom is on the left.
  const auto quarter = static_cast<float>(std::numbers::pi / 2);
  equal(reference_point(box, quarter, Reference::Bottom), 0, 40);
  equal(reference_point(box, quarter, Reference::Top), 40, 40);
}

TEST(Ground, ScalesPixels) {
  const auto at = Ground(0.05).to_metres({100, 40});
  ASSERT_TRUE(at);
  EXPECT_DOUBLE_EQ(at->x, 5);
  EXPECT_DOUBLE_EQ(at->y, 2);
}

// The trapezoid is the picture of a square of 1 m: x = (4u + v + 1) / (v + 2) and so on, computed
// by hand for the corners.
TEST(Ground, FollowsTheEquationsOfAHomography) {
  const auto pixel = [](double u, double v) {
    return Point{(400 * u + 100 * v + 100) / (v + 2), (50 * u + 300 * v + 20) / (v + 2)};
  };
  const auto ground = Ground::from_points({pixel(0, 0), pixel(1, 0), pixel(1, 1), pixel(0, 1)},
                                          {Point{0, 0}, {1, 0}, {1, 1}, {0, 1}});
  ASSERT_TRUE(ground);
  for (double v = -1; v < 5; v += 0.3)
    for (double u = -3; u < 5; u += 0.7) {
      const auto at = ground->to_metres(pixel(u, v));
      ASSERT_TRUE(at) << u << ", " << v;
      EXPECT_NEAR(at->x, u, 1e-6);
      EXPECT_NEAR(at->y, v, 1e-6);
    }
}

TEST(Ground, HasNothingBeyondTheHorizon) {
  // A road to a vanishing point at 50, 0: the lines through its edges meet there.
  const auto ground = Ground::from_points({Point{0, 100}, {100, 100}, {75, 50}, {25, 50}},
                                          {Point{0, 0}, {4, 0}, {4, 10}, {0, 10}});
  ASSERT_TRUE(ground);
  EXPECT_TRUE(ground->to_metres({50, 1}));
  EXPECT_FALSE(ground->to_metres({50, 0}));
  EXPECT_FALSE(ground->to_metres({50, -20}));
  EXPECT_FALSE(ground->to_metres({NAN, 50}));
}

TEST(Ground, RejectsPointsOnALineAndCornersInAnotherOrder) {
  const std::array<Point, 4> square{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
  EXPECT_FALSE(Ground::from_points({Point{0, 0}, {1, 1}, {2, 2}, {0, 5}}, square));
  EXPECT_FALSE(Ground::from_points(square, {Point{0, 0}, {0, 0}, {1, 1}, {0, 1}}));
  EXPECT_FALSE(Ground::from_points(square, {Point{0, 0}, {1, 1}, {1, 0}, {0, 1}}));
}

}  // namespace geometry_test
}  // namespace weir::zone
