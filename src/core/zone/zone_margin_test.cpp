// Tests of objects that stay near a line or the border of an area.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cmath>

#include "core/zone/zone_counter_test_support.hpp"

namespace weir::zone {
namespace zone_margin_test {

// Boxes are 20 high: a margin of 0.1 is 2 pixels.
class NearALine : public ZoneCounterTest {
 protected:
  void SetUp() override {
    gate_ = line("gate", {0, 100}, {1000, 100});
    gate_.margin = 0.1;
    use({gate_});
  }
  // The events of an object whose bottom is at these heights in frames 0.1 s apart, in one line.
  std::string events_at(const std::vector<double>& heights) {
    std::string out;
    for (const double y : heights) {
      const auto events = frame(time_ += 0.1, {at(500, y, 7)});
      out += events.empty() ? '.' : events[0][0];
    }
    return out;
  }
  Zone gate_;
  double time_ = 0;
};

TEST_F(NearALine, ACrossingThatGoesOnCountsAtOnce) {
  EXPECT_EQ(events_at({90, 99, 101, 103, 120}), "..f..");
  EXPECT_EQ(events_at({103, 99, 97, 103}), ".b.f");
}

TEST_F(NearALine, TremblingCountsOnce) {
  EXPECT_EQ(events_at({90, 101, 99, 101, 98, 102, 99, 100, 99.9, 101}), ".f........");
  EXPECT_EQ(events_at({103, 120}), "..") << "it is where it was counted";
  EXPECT_EQ(total(0).forward, 1u);
  EXPECT_EQ(total(0).backward, 0u);
}

TEST_F(NearALine, TurningBackCountsWhereItIsClear) {
  EXPECT_EQ(events_at({90, 101, 99, 98, 97.9, 90}), ".f..b.");
  EXPECT_EQ(events_at({101, 99, 101, 99, 101, 110}), "f.....") << "the next passage is a new one";
  EXPECT_EQ(total(0).forward, 2u);
  EXPECT_EQ(total(0).backward, 1u);
}

TEST_F(NearALine, TheMarginIsThatOfTheLongerSideOfTheBox) {
  const auto box = [](float y, float width, float height) {
    return Sighting{.track = 1, .class_index = 0, .box = {50, y - height, 50 + width, y}};
  };
  for (const auto& [width, height] : {std::pair{300.0f, 10.0f}, {10.0f, 300.0f}}) {
    counter.reset();
    frame(0, {box(50, width, height)});
    frame(0.1, {box(101, width, height)});
    EXPECT_EQ(frame(0.2, {box(71, width, height)}), Texts()) << "30 pixels are not yet clear";
    EXPECT_EQ(frame(0.3, {box(69, width, height)}), Texts{"backward gate 1"});
  }
}

TEST_F(NearALine, WithoutAMarginEachCrossingCounts) {
  gate_.margin = 0;
  use({gate_});
  EXPECT_EQ(events_at({90, 101, 99, 100, 99.9}), ".fbfb");
}

TEST_F(NearALine, GoingRoundTheEndOfALineIsNoCrossing) {
  const auto walk = [this](double x, double y) { return frame(time_ += 0.1, {at(x, y, 7)}); };
  walk(2, 90);
  EXPECT_EQ(walk(1, 101), Texts{"forward gate 7"});
  EXPECT_EQ(walk(-1, 101), Texts());
  EXPECT_EQ(walk(-1, 99), Texts());
  EXPECT_EQ(walk(-1, 90), Texts());
  EXPECT_EQ(total(0).backward, 0u);
}

TEST_F(NearALine, EachTrackAndLineTremblesAlone) {
  auto other = line("other", {0, 101}, {1000, 101});
  other.margin = 0.1;
  use({gate_, other});
  frame(0, {at(10, 90, 1), at(500, 110, 2)});
  EXPECT_EQ(frame(0.1, {at(10, 102, 1), at(500, 100.5, 2)}),
            (Texts{"forward gate 1", "forward other 1", "backward other 2"}));
  EXPECT_EQ(frame(0.2, {at(10, 100.5, 1), at(500, 99.5, 2)}), Texts{"backward gate 2"});
  EXPECT_EQ(frame(0.3, {at(10, 90, 1), at(500, 110, 2)}),
            (Texts{"backward gate 1", "backward other 1", "forward gate 2", "forward other 2"}));
}

TEST_F(NearALine, AZoneFileThatChangesKeepsWhoIsNear) {
  EXPECT_EQ(events_at({90, 101}), ".f");
  use({area("new", 0, 0, 9, 9), gate_});
  EXPECT_EQ(events_at({99, 101, 99}), "...");
  use({area("gate", 0, 0, 9, 9), area("new", 0, 0, 9, 9)});
  EXPECT_EQ(events_at({99, 101}), "..");
  use({gate_});
  EXPECT_EQ(events_at({99}), "b") << "another line of that name";
}

TEST_F(NearALine, ATrackThatEndsThereIsForgotten) {
  EXPECT_EQ(events_at({90, 101, 99}), ".f.");
  time_ += 5;
  EXPECT_EQ(events_at({90, 80}), "..") << "a new track";
}

// Random walks over a line that is longer than the walk. Where the object is clear of the line, the
// side on which it is follows from the counts; and the margin never adds events.
TEST_F(NearALine, CountsFollowTheSideInRandomWalks) {
  auto plain = gate_;
  plain.name = "plain", plain.margin = 0;
  use({gate_, plain});
  uint32_t state = 1;
  double y = 90;
  frame(0, {at(500, y, 7)});
  for (int i = 1; i < 20000; ++i) {
    state = state * 1664525 + 1013904223;
    y = std::clamp(y + (static_cast<double>(state >> 16) / 65535 - 0.5) * 3, 85.0, 115.0);
    frame(i * 0.1, {at(500, y, 7)});
    if (std::abs(y - 100) <= 2.001) continue;
    ASSERT_EQ(total(0).forward - total(0).backward, y > 100 ? 1u : 0u) << i;
  }
  EXPECT_GT(total(0).forward, 20u);
  EXPECT_LT(2 * total(0).forward, total(1).forward);
}

TEST_F(ZoneCounterTest, AnAreaWithAMarginKeepsWhoTremblesOnItsBorder) {
  auto yard = area("yard", 0, 0, 100, 100, 0.5), plain = area("plain", 0, 0, 100, 100);
  yard.margin = 0.1;
  use({yard, plain});
  frame(0, {at(50, 101, 7)});
  EXPECT_EQ(total(0).entered, 0u) << "near it is not in it";
  EXPECT_EQ(frame(0.1, {at(50, 99, 7)}), (Texts{"enter yard 7", "enter plain 7"}));
  EXPECT_EQ(frame(0.2, {at(50, 101.9, 7)}), Texts{"leave plain 7"});
  EXPECT_EQ(total(0).inside(), 1u);
  EXPECT_EQ(frame(0.6, {at(50, 101, 7)}), Texts{"dwell yard 7"});
  EXPECT_EQ(frame(0.7, {at(50, 102.1, 7)}), Texts{"leave yard 7"});
  EXPECT_EQ(frame(0.8, {at(50, 101, 7)}), Texts());
  expect_balance();
}

}  // namespace zone_margin_test
}  // namespace weir::zone
