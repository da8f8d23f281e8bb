// Tests of stays, crossings, speeds and counts over frames.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/zone/zone_counter_test_support.hpp"

namespace weir::zone {
namespace zone_counter_test {

TEST_F(ZoneCounterTest, SaysWhoEntersStaysAndLeaves) {
  use({area("yard", 100, 100, 200, 200)});
  EXPECT_EQ(frame(0, {at(50, 150, 7)}), Texts());
  EXPECT_EQ(frame(1, {at(120, 150, 7)}), Texts{"enter yard 7"});
  ASSERT_EQ(counter.get_presences(0).size(), 1u);
  EXPECT_FLOAT_EQ(counter.get_presences(0)[0].dwell, 0);
  EXPECT_EQ(frame(1.5, {at(130, 150, 7)}), Texts());
  EXPECT_FLOAT_EQ(counter.get_presences(0)[0].dwell, 0.5f);
  EXPECT_EQ(total(0).inside(), 1u);
  EXPECT_EQ(frame(2, {at(250, 150, 7)}), Texts{"leave yard 7"});
  EXPECT_FLOAT_EQ(counter.events()[0].dwell, 1);
  EXPECT_EQ(counter.get_presences(0).size(), 0u);
  EXPECT_EQ(total(0).entered, 1u);
  EXPECT_EQ(total(0).left, 1u);
  EXPECT_EQ(total(0).inside(), 0u);
}

TEST_F(ZoneCounterTest, OverlappingAreasEachHaveTheObject) {
  use({area("all", 0, 0, 300, 300), area("far", 500, 0, 600, 300), area("part", 100, 0, 200, 300)});
  EXPECT_EQ(frame(0, {at(50, 150, 7), at(150, 150, 8)}),
            (Texts{"enter all 7", "enter all 8", "enter part 8"}));
  ASSERT_EQ(counter.get_presences(0).size(), 1u);
  ASSERT_EQ(counter.get_presences(1).size(), 2u);
  EXPECT_EQ(counter.get_presences(1)[1].zone, 2u);
  EXPECT_EQ(total(0).inside(), 2u);
  EXPECT_EQ(total(2).inside(), 1u);
}

TEST_F(ZoneCounterTest, ReportsALongStayOnce) {
  use({area("bench", 0, 0, 100, 100, 0.5)});
  EXPECT_EQ(frame(0, {at(50, 50, 3)}), Texts{"enter bench 3"});
  EXPECT_EQ(frame(0.4, {at(50, 50, 3)}), Texts());
  EXPECT_EQ(frame(0.5, {at(50, 50, 3)}), Texts{"dwell bench 3"});
  EXPECT_EQ(frame(0.6, {at(50, 50, 3)}), Texts());
  EXPECT_EQ(frame(0.7, {at(150, 50, 3)}), Texts{"leave bench 3"});
  EXPECT_EQ(frame(0.8, {at(50, 50, 3)}), Texts{"enter bench 3"});
  EXPECT_EQ(frame(1.2, {at(50, 50, 3)}), Texts());
  EXPECT_EQ(frame(1.3, {at(50, 50, 3)}), Texts{"dwell bench 3"});
}

TEST_F(ZoneCounterTest, CountsCrossingsByDirectionAndClass) {
  use({line("gate", {0, 100}, {200, 100})});
  EXPECT_EQ(frame(0, {at(50, 90, 1, 0), at(60, 110, 2, 5)}), Texts());
  EXPECT_EQ(frame(0.1, {at(50, 110, 1, 0), at(60, 90, 2, 5)}),
            (Texts{"forward gate 1", "backward gate 2"}));
  EXPECT_EQ(frame(0.2, {at(50, 90, 1, 0), at(460, 110, 2, 5)}), Texts{"backward gate 1"});
  EXPECT_EQ(total(0).forward, 1u);
  EXPECT_EQ(total(0).backward, 2u);
  EXPECT_EQ(counter.counts()[0].of_class.at(0).backward, 1u);
  EXPECT_EQ(counter.counts()[0].of_class.at(5).backward, 1u);
  EXPECT_EQ(counter.counts()[0].of_class.at(5).forward, 0u);
}

TEST_F(ZoneCounterTest, UsesTheReferenceOfTheZone) {
  auto top = line("top", {0, 100}, {200, 100});
  top.reference = Reference::Top;
  auto centre = area("centre", 0, 0, 200, 100);
  centre.reference = Reference::Centre;
  use({line("bottom", {0, 100}, {200, 100}), top, centre});
  // Boxes are 20 high.
  EXPECT_EQ(frame(0, {at(50, 95, 1)}), Texts{"enter centre 1"});
  EXPECT_EQ(frame(0.1, {at(50, 105, 1)}), Texts{"forward bottom 1"});
  EXPECT_EQ(frame(0.2, {at(50, 115, 1)}), Texts{"leave centre 1"});
  EXPECT_EQ(frame(0.3, {at(50, 125, 1)}), Texts{"forward top 1"});
}

TEST_F(ZoneCounterTest, KeepsATrackThroughAShortGap) {
  use({area("yard", 0, 0, 100, 100), line("gate", {0, 100}, {100, 100})});
  frame(0, {at(50, 50, 7)});
  EXPECT_EQ(frame(0.5, {}), Texts());
  EXPECT_EQ(total(0).inside(), 1u) << "it is not gone yet";
  EXPECT_EQ(frame(1.0, {at(50, 60, 7)}), Texts());
  EXPECT_FLOAT_EQ(counter.get_presences(0)[0].dwell, 1);
  EXPECT_EQ(frame(1.9, {at(50, 120, 7)}), (Texts{"leave yard 7", "forward gate 7"}));
}

TEST_F(ZoneCounterTest, ATrackThatVanishesLeaves) {
  use({area("yard", 0, 0, 100, 100)});
  frame(0, {at(50, 50, 7, 2)});
  frame(0.25, {at(50, 50, 7, 2)});
  EXPECT_EQ(frame(1.25, {}), Texts());
  EXPECT_EQ(frame(1.3, {}), Texts{"leave yard 7"});
  EXPECT_FLOAT_EQ(counter.events()[0].dwell, 0.25f) << "until it was seen last";
  EXPECT_EQ(counter.events()[0].class_index, 2);
  EXPECT_EQ(counter.tracks(), 0u);
  EXPECT_EQ(frame(1.4, {}), Texts());
  expect_balance();
}

TEST_F(ZoneCounterTest, ANumberThatIsUsedAgainIsANewTrack) {
  use({area("yard", 0, 0, 100, 100), line("gate", {0, 200}, {100, 200})});
  frame(0, {at(50, 50, 7)});
  EXPECT_EQ(frame(5, {at(50, 210, 7)}), Texts{"leave yard 7"}) << "it has not crossed the gate";
  EXPECT_EQ(frame(5.1, {at(50, 50, 7)}), (Texts{"enter yard 7", "backward gate 7"}));
  EXPECT_EQ(total(0).entered, 2u);
}

TEST_F(ZoneCounterTest, ALaterTimeEndsNoTrackThatIsThere) {
  counter = ZoneCounter({.max_gap = 2 * kSecond});
  use({area("yard", 0, 0, 100, 100)});
  frame(0, {at(50, 50, 7)});
  EXPECT_EQ(frame(2, {at(50, 50, 7)}), Texts());
  EXPECT_EQ(frame(4.5, {at(50, 50, 7)}), (Texts{"leave yard 7", "enter yard 7"}));
}

TEST_F(ZoneCounterTest, ATimeThatGoesBackEndsAllTracks) {
  use({area("yard", 0, 0, 100, 100), line("gate", {0, 60}, {100, 60})});
  frame(10, {at(50, 50, 7), at(20, 20, 8)});
  EXPECT_FALSE(counter.is_backward(10 * kSecond));
  EXPECT_TRUE(counter.is_backward(10 * kSecond - 1));
  frame(3, {at(50, 70, 7)});
  auto events = texts_of(counter);
  std::sort(events.begin(), events.end());
  EXPECT_EQ(events, (Texts{"enter yard 7", "leave yard 7", "leave yard 8"}));
  EXPECT_EQ(counter.times_backward(), 1u);
  EXPECT_EQ(frame(3.1, {at(50, 50, 7)}), Texts{"backward gate 7"});
  expect_balance();
}

TEST_F(ZoneCounterTest, ARepeatedTimeAddsNothingToSpeedAndDwell) {
  use({area("yard", 0, 0, 100, 100), line("gate", {0, 60}, {100, 60})});
  frame(1, {at(50, 50, 7)});
  EXPECT_EQ(frame(1, {at(50, 70, 7)}), Texts{"forward gate 7"}) << "crossings count";
  EXPECT_FLOAT_EQ(counter.get_presences(0)[0].dwell, 0);
  EXPECT_TRUE(std::isnan(counter.speeds()[0].pixels));
  counter.update(kNoTime, Sightings{at(50, 80, 7)});
  EXPECT_TRUE(std::isnan(counter.speeds()[0].pixels));
  EXPECT_EQ(total(0).inside(), 1u);
}

TEST_F(ZoneCounterTest, FramesWithoutTimesAreCounted) {
  use({line("gate", {0, 60}, {100, 60})});
  counter.update(kNoTime, Sightings{at(50, 50, 7)});
  counter.update(kNoTime, Sightings{at(50, 70, 7)});
  EXPECT_EQ(total(0).forward, 1u);
}

TEST_F(ZoneCounterTest, SpeedIsThatOfASteadyMove) {
  use({area("yard", 0, 0, 1000, 1000)});
  // 3, 4 pixels every 0.1 s: 50 pixels a second.
  for (int i = 0; i < 40; ++i) {
    frame(0.1 * i, {at(100 + 3 * i, 100 + 4 * i, 7), at(10, 10, 8)});
    if (i == 0) {
      EXPECT_TRUE(std::isnan(counter.speeds()[0].pixels));
      continue;
    }
    EXPECT_NEAR(counter.speeds()[0].pixels, 50, 1e-3) << i;
    EXPECT_NEAR(counter.speeds()[1].pixels, 0, 1e-3);
    EXPECT_NEAR(total(0).mean_speed().pixels, 25, 1e-3);
    EXPECT_TRUE(std::isnan(counter.speeds()[0].metres)) << "no ground";
  }
}

TEST_F(ZoneCounterTest, SpeedIsTheMeanOfTheLastSecond) {
  use({});
  for (int i = 0; i <= 10; ++i) frame(0.1 * i, {at(10 * i, 0, 7)});  // 100 a second
  for (int i = 1; i <= 5; ++i) frame(1 + 0.1 * i, {at(100, 0, 7)});  // stands
  EXPECT_NEAR(counter.speeds()[0].pixels, 50, 1e-3);
  for (int i = 6; i <= 10; ++i) frame(1 + 0.1 * i, {at(100, 0, 7)});
  EXPECT_NEAR(counter.speeds()[0].pixels, 0, 1e-3);
}

TEST_F(ZoneCounterTest, SpeedOnTheGroundIsInMetres) {
  counter.set_zones(std::make_shared<const ZoneSet>(ZoneSet{{}, Ground(0.05), {}}));
  frame(0, {at(100, 100, 7)});
  frame(0.5, {at(100, 160, 7)});
  EXPECT_NEAR(counter.speeds()[0].pixels, 120, 1e-3);
  EXPECT_NEAR(counter.speeds()[0].metres, 6, 1e-4);
}

TEST_F(ZoneCounterTest, ObjectsWithoutATrackAreOnlyInside) {
  use({area("yard", 0, 0, 100, 100), line("gate", {0, 60}, {100, 60})});
  EXPECT_EQ(frame(0, {at(50, 50, 0, 1), at(60, 50, 0, 1)}), Texts());
  EXPECT_EQ(total(0).inside(), 2u);
  EXPECT_EQ(counter.counts()[0].of_class.at(1).inside(), 2u);
  ASSERT_EQ(counter.get_presences(0).size(), 1u);
  EXPECT_TRUE(std::isnan(counter.get_presences(0)[0].dwell));
  EXPECT_EQ(frame(0.1, {at(50, 70, 0, 1)}), Texts());
  EXPECT_EQ(total(0).inside(), 1u);
  EXPECT_EQ(total(0).entered, 0u);
}

TEST_F(ZoneCounterTest, ANumberTwiceInAFrameIsOneTrack) {
  use({area("yard", 0, 0, 100, 100)});
  EXPECT_EQ(frame(0, {at(50, 50, 7), at(60, 50, 7)}), Texts{"enter yard 7"});
  EXPECT_EQ(total(0).entered, 1u);
  EXPECT_EQ(total(0).inside(), 2u);
  EXPECT_EQ(frame(0.1, {at(50, 50, 7)}), Texts());
  EXPECT_EQ(total(0).inside(), 1u);
}

TEST_F(ZoneCounterTest, TracksOfTwoGroupsAreDifferent) {
  use({area("yard", 0, 0, 100, 100)});
  auto other = at(60, 50, 7);
  other.group = 1;
  EXPECT_EQ(frame(0, {at(50, 50, 7), other}).size(), 2u);
  EXPECT_EQ(total(0).entered, 2u);
}

TEST_F(ZoneCounterTest, AClassThatChangesLeavesAsItEntered) {
  use({area("yard", 0, 0, 100, 100)});
  frame(0, {at(50, 50, 7, 2)});
  frame(0.1, {at(50, 50, 7, 3)});
  EXPECT_EQ(counter.counts()[0].of_class.at(2).inside(), 1u);
  EXPECT_EQ(counter.counts()[0].of_class.count(3), 0u);
  frame(0.2, {at(150, 50, 7, 3)});
  EXPECT_EQ(counter.counts()[0].of_class.at(2).left, 1u);
  expect_balance();
}

TEST_F(ZoneCounterTest, NewZonesKeepTheCountsOfTheSameNames) {
  use({area("a", 0, 0, 100, 100), area("gone", 0, 0, 100, 100), line("gate", {0, 60}, {100, 60})});
  frame(0, {at(50, 50, 7)});
  frame(0.5, {at(50, 70, 7)});
  use({line("gate", {0, 90}, {100, 90}), area("new", 0, 0, 100, 100), area("a", 0, 0, 200, 200)});
  EXPECT_EQ(total(0).forward, 1u);
  EXPECT_EQ(total(1).entered, 0u);
  EXPECT_EQ(total(2).entered, 1u);
  EXPECT_EQ(frame(1, {at(50, 95, 7)}), (Texts{"forward gate 7", "enter new 7"}));
  EXPECT_EQ(total(0).forward, 2u);
  ASSERT_EQ(counter.get_presences(0).size(), 2u);
  EXPECT_FLOAT_EQ(counter.get_presences(0)[0].dwell, 0);
  EXPECT_FLOAT_EQ(counter.get_presences(0)[1].dwell, 1) << "a";
  EXPECT_EQ(frame(1.1, {at(50, 500, 7)}), (Texts{"leave new 7", "leave a 7"}));
  expect_balance();
}

TEST_F(ZoneCounterTest, AnotherKindUnderTheSameNameIsANewZone) {
  use({area("a", 0, 0, 100, 100)});
  frame(0, {at(50, 50, 7)});
  use({line("a", {0, 60}, {100, 60})});
  EXPECT_EQ(total(0).entered, 0u);
  EXPECT_EQ(frame(0.1, {at(50, 70, 7)}), Texts{"forward a 7"});
}

TEST_F(ZoneCounterTest, ResetForgetsCountsAndForgetTracksDoesNot) {
  use({area("yard", 0, 0, 100, 100)});
  frame(5, {at(50, 50, 7)});
  counter.forget_tracks();
  EXPECT_EQ(texts_of(counter), Texts{"leave yard 7"});
  EXPECT_EQ(total(0).entered, 1u);
  EXPECT_EQ(frame(0, {at(50, 50, 7)}), Texts{"enter yard 7"}) << "an earlier time";
  EXPECT_EQ(counter.times_backward(), 0u);
  counter.reset();
  EXPECT_EQ(total(0).entered, 0u);
  EXPECT_EQ(counter.tracks(), 0u);
}

TEST_F(ZoneCounterTest, LimitsAreCounted) {
  std::vector<Zone> many;
  for (size_t i = 0; i < kStayLimit + 20; ++i) many.push_back(area(std::to_string(i), 0, 0, 9, 9));
  use(many);
  frame(0, {at(5, 5, 7)});
  EXPECT_EQ(counter.get_presences(0).size(), kStayLimit);
  EXPECT_EQ(counter.left_out(), 20u);
  Sightings crowd;
  for (uint32_t i = 1; i <= kTrackLimit + 5; ++i) crowd.push_back(at(500, 500, i));
  frame(0.1, crowd);
  EXPECT_EQ(counter.tracks(), kTrackLimit);
  EXPECT_EQ(counter.left_out(), 25u);
}

// A new number every frame, for an hour at 30 frames a second.
TEST_F(ZoneCounterTest, MemoryIsThatOfTheTracksOfOneSecond) {
  use({area("yard", 0, 0, 100, 100), line("gate", {0, 60}, {100, 60})});
  for (uint32_t i = 0; i < 108000; ++i) {
    frame(i / 30.0, {at(50, 50, 1 + i, static_cast<int32_t>(i % 1000))});
    ASSERT_LE(counter.tracks(), 32u) << i;
  }
  EXPECT_EQ(total(0).entered, 108000u);
  EXPECT_EQ(total(0).left, 108000u - total(0).inside());
  EXPECT_EQ(counter.counts()[0].of_class.size(), 1000u);
  expect_balance();
}

TEST_F(ZoneCounterTest, ClassesBeyondTheLimitAreInTheTotal) {
  use({area("yard", 0, 0, 100, 100)});
  for (uint32_t i = 0; i < kClassLimit + 10; ++i)
    counter.update(int64_t{i} * 2 * kSecond, Sightings{at(50, 50, 1, static_cast<int32_t>(i))});
  EXPECT_EQ(counter.counts()[0].of_class.size(), kClassLimit);
  EXPECT_EQ(total(0).entered, kClassLimit + 10);
  expect_balance();
}

// Detectors extend the boxes of objects that the edge of the picture cuts.
TEST_F(ZoneCounterTest, PointsBeyondThePictureAreAtItsEdge) {
  use({area("left", 0, 0, 50, 100), line("middle", {50, 0}, {50, 100})});
  EXPECT_EQ(frame(0, {at(20, 103, 1)}), Texts{}) << "without a size the point is below the area";
  counter.set_picture({100, 100});
  EXPECT_EQ(frame(0.1, {at(22, 104, 1)}), Texts{"enter left 1"});
  EXPECT_EQ(frame(0.2, {at(24, 99, 1)}), Texts{});
  EXPECT_EQ(frame(0.3, {at(52, 108, 1)}), (Texts{"leave left 1", "backward middle 1"}));
  EXPECT_EQ(frame(0.4, {at(-3, 50, 2)}), Texts{"enter left 2"}) << "a part of it is seen";
  EXPECT_EQ(frame(0.5, {at(-8, 50, 2)}), Texts{"leave left 2"}) << "nothing of it is seen";
  expect_balance();
}

TEST_F(ZoneCounterTest, LinesOnTheEdgesOfThePictureAreCrossed) {
  use({line("bottom", {0, 100}, {100, 100}), line("right", {100, 100}, {100, 0}),
       line("top", {100, 0}, {0, 0})});
  counter.set_picture({100, 100});
  // Boxes are 20 high, the points in the middle of their lower edge.
  EXPECT_EQ(frame(0, {at(50, 95, 1), at(95, 50, 2), at(50, 5, 3)}), Texts());
  EXPECT_EQ(frame(0.1, {at(50, 105, 1), at(102, 50, 2), at(50, -5, 3)}),
            (Texts{"forward bottom 1", "forward right 2", "forward top 3"}));
  EXPECT_EQ(frame(0.2, {at(50, 95, 1)}), Texts{"backward bottom 1"});
}

}  // namespace zone_counter_test
}  // namespace weir::zone
