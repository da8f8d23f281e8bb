// Each rule of each policy, one decision at a time.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <gtest/gtest.h>

#include "core/sync/options.hpp"

namespace weir::sync {
namespace policies_test {

PadView head(Stamp time) {
  PadView pad;
  pad.state = PadState::Head;
  pad.head = time;
  return pad;
}
PadView in_state(PadState state) {
  PadView pad;
  pad.state = state;
  return pad;
}
PadView gap(Time end) {
  PadView pad = in_state(PadState::Gap);
  pad.gap_end = end;
  return pad;
}
PadView with_kept(PadView pad, Stamp time) {
  pad.has_kept = true;
  pad.kept = time;
  return pad;
}
const PadView kEmpty = in_state(PadState::Empty), kMissing = in_state(PadState::Missing),
              kEnded = in_state(PadState::Ended);

Decision decide_for(Mode mode, std::vector<PadView> pads, Round round = {}, Base base = {}) {
  return decide({mode, base, {}}, round, pads);
}
using Uses = std::vector<Use>;
constexpr Mode kAll[] = {Mode::NoSync, Mode::Slowest, Mode::BasePad, Mode::Refresh};
constexpr Mode kWaiting[] = {Mode::NoSync, Mode::Slowest, Mode::BasePad};

TEST(Policies, NoneEmitsBeforeEachPadHasAFrame) {
  for (const Mode mode : kAll) {
    const auto d = decide_for(mode, {head(5), kEmpty});
    EXPECT_EQ(d.outcome, Outcome::Wait) << to_string(mode);
    EXPECT_EQ(d.uses, (Uses{Use::Nothing, Use::Nothing})) << to_string(mode);
    EXPECT_EQ(d.round, Round{}) << to_string(mode);
  }
}

TEST(Policies, ThreeEndWithTheFirstPadThatEnds) {
  for (const Mode mode : kWaiting) {
    EXPECT_EQ(decide_for(mode, {head(5), kEnded}).outcome, Outcome::End) << to_string(mode);
    EXPECT_EQ(decide_for(mode, {kEmpty, kEnded}).outcome, Outcome::End) << to_string(mode);
  }
}

TEST(Policies, APadThatEndsDuringARepeatedRoundContributesItsKeptFrame) {
  for (const Mode mode : {Mode::Slowest, Mode::BasePad}) {
    const Round repeated{30, false, 0, {}};
    const auto d = decide_for(mode, {head(30), with_kept(kEnded, 20)}, repeated);
    EXPECT_EQ(d.outcome, Outcome::Emit) << to_string(mode);
    EXPECT_EQ(d.round.current, 30u) << to_string(mode);
    EXPECT_EQ(d.uses, (Uses{Use::Head, Use::Kept})) << to_string(mode);
    EXPECT_TRUE(d.round.need_set) << to_string(mode);
    const auto waits = decide_for(mode, {head(30), with_kept(kEnded, 20), kEmpty}, repeated);
    EXPECT_EQ(waits.outcome, Outcome::Wait) << to_string(mode);
  }
}

TEST(Policies, APadThatEndsWhileARoundIsRepeatedEndsTheStreamWithoutAKeptFrame) {
  for (const Mode mode : {Mode::Slowest, Mode::BasePad}) {
    const Round repeated{30, false, 0, {}};
    EXPECT_EQ(decide_for(mode, {head(30), kEnded}, repeated).outcome, Outcome::End)
        << to_string(mode);
    const auto all = decide_for(mode, {with_kept(kEnded, 20), with_kept(kEnded, 20)}, repeated);
    EXPECT_EQ(all.outcome, Outcome::End) << to_string(mode);
  }
}

TEST(Policies, ANewRoundEndsWithAPadThatHasEnded) {
  for (const Mode mode : kWaiting)
    EXPECT_EQ(decide_for(mode, {head(30), with_kept(kEnded, 20)}).outcome, Outcome::End)
        << to_string(mode);
}

TEST(Policies, RefreshEndsWithTheLast) {
  EXPECT_EQ(decide_for(Mode::Refresh, {kEmpty, with_kept(kEnded, 1)}).outcome, Outcome::Wait);
  EXPECT_EQ(decide_for(Mode::Refresh, {kEnded, kEnded}).outcome, Outcome::End);
  EXPECT_EQ(decide_for(Mode::Refresh, {head(7), with_kept(kEnded, 1)}).outcome, Outcome::Emit);
}

TEST(Policies, NoPadsNoDecision) {
  for (const Mode mode : {Mode::NoSync, Mode::Slowest, Mode::Refresh})
    EXPECT_EQ(decide_for(mode, {}).outcome, Outcome::Wait) << to_string(mode);
}

TEST(Policies, TheHighestHeadGivesTimeAndMetadata) {
  for (const Mode mode : {Mode::NoSync, Mode::Refresh}) {
    const auto d = decide_for(mode, {head(5), head(9), head(9), head(2)});
    EXPECT_EQ(d.outcome, Outcome::Emit);
    EXPECT_EQ(d.round.current, 9u);
    EXPECT_EQ(d.metadata_pad, 1u) << to_string(mode);
    EXPECT_TRUE(d.round.need_set);
    EXPECT_EQ(d.uses, Uses(4, Use::Head));
  }
}

TEST(Policies, CurrentNeverFalls) {
  for (const Mode mode : {Mode::NoSync, Mode::Refresh}) {
    const auto d = decide_for(mode, {head(5), head(9)}, {100, true, {}, {}});
    EXPECT_EQ(d.round.current, 100u) << to_string(mode);
    EXPECT_EQ(d.metadata_pad, 0u) << to_string(mode);
  }
}

TEST(Policies, FramesWithoutTimeFitEveryTime) {
  for (const Mode mode : kAll) {
    const auto d = decide_for(mode, {head(40), head({})});
    EXPECT_EQ(d.outcome, Outcome::Emit) << to_string(mode);
    EXPECT_EQ(d.round.current, 40u) << to_string(mode);
    EXPECT_EQ(d.uses, Uses(2, Use::Head)) << to_string(mode);
  }
}

TEST(Policies, WithoutAnyTimeTheOutputIsAtZero) {
  for (const Mode mode : kAll) {
    const auto d = decide_for(mode, {head({}), head({})});
    EXPECT_EQ(d.outcome, Outcome::Emit) << to_string(mode);
    EXPECT_EQ(d.round.current, 0u) << to_string(mode);
  }
}

TEST(Slowest, DiscardsWhatIsTooOldAndChangesNoOtherPad) {
  const auto d = decide_for(Mode::Slowest, {head(29), head(14)});
  EXPECT_EQ(d.outcome, Outcome::Wait);
  EXPECT_EQ(d.uses, (Uses{Use::Nothing, Use::Discard}));
  EXPECT_EQ(d.round, (Round{29, false, 0, {}}));
}

TEST(Slowest, DiscardsWhatIsTooOldWithoutTheOthers) {
  const Round round{30, true, {}, {}};
  const auto d = decide_for(Mode::Slowest, {kEmpty, head(29), head(30), head({})}, round);
  EXPECT_EQ(d.outcome, Outcome::Wait);
  EXPECT_EQ(d.uses, (Uses{Use::Nothing, Use::Discard, Use::Nothing, Use::Nothing}));
  EXPECT_EQ(d.round, (Round{30, true, {}, {false, true, false, false}}));
}

TEST(Slowest, TheHeadAfterADiscardedOneDoesNotRaiseTheTime) {
  const Round round{30, true, {}, {false, true}};
  const auto d = decide_for(Mode::Slowest, {head(40), with_kept(head(50), 29)}, round);
  EXPECT_EQ(d.outcome, Outcome::Emit);
  EXPECT_EQ(d.round.current, 40u);
  EXPECT_EQ(d.uses, (Uses{Use::Head, Use::Head}));
}

TEST(Slowest, APadWithADiscardedFrameContributesEvenWhenItEnds) {
  const Round begun{30, true, {}, {false, true}};
  EXPECT_EQ(decide_for(Mode::Slowest, {kEmpty, with_kept(kEnded, 29)}, begun).outcome,
            Outcome::Wait);
  const auto d = decide_for(Mode::Slowest, {head(40), with_kept(kEnded, 29)}, begun);
  EXPECT_EQ(d.outcome, Outcome::Emit);
  EXPECT_EQ(d.uses, (Uses{Use::Head, Use::Kept}));
  EXPECT_EQ(decide_for(Mode::Slowest, {kEnded, with_kept(kEnded, 29)}, begun).outcome,
            Outcome::End);
}

TEST(Slowest, HoldsWhatMayBeginANewStream) {
  PadView back = head(3);
  back.went_back = true;
  const auto d = decide_for(Mode::Slowest, {kEmpty, back}, {30, true, {}, {}});
  EXPECT_EQ(d.uses, (Uses{Use::Nothing, Use::Nothing}));
}

TEST(Slowest, ContinuesWithTheSameTimeAfterADiscard) {
  const auto d = decide_for(Mode::Slowest, {head(29), with_kept(head(30), 14)}, {29, false, 0, {}});
  EXPECT_EQ(d.outcome, Outcome::Emit);
  EXPECT_EQ(d.round.current, 29u);
  EXPECT_EQ(d.uses, (Uses{Use::Head, Use::Head}));
  EXPECT_EQ(d.metadata_pad, 0u);
}

TEST(Slowest, UsesTheKeptFrameWhenItIsNearer) {
  const auto nearer = with_kept(head(40), 28);
  const auto d = decide_for(Mode::Slowest, {head(29), nearer}, {29, false, 0, {}});
  EXPECT_EQ(d.uses, (Uses{Use::Head, Use::Kept}));
  // At equal distance: the head.
  const auto as_near = with_kept(head(31), 27);
  EXPECT_EQ(decide_for(Mode::Slowest, {head(29), as_near}, {29, false, 0, {}}).uses,
            (Uses{Use::Head, Use::Head}));
}

TEST(Slowest, AGapRaisesTheTimeThatOthersMustReach) {
  const auto d = decide_for(Mode::Slowest, {head(29), with_kept(gap(60), 10)});
  EXPECT_EQ(d.outcome, Outcome::Wait);
  EXPECT_EQ(d.uses, (Uses{Use::Discard, Use::Nothing}));
  EXPECT_TRUE(d.round.need_set);
  EXPECT_EQ(decide_for(Mode::Slowest, {head(60), gap(60)}).uses, Uses(2, Use::Nothing));
}

TEST(Slowest, AGapSettlesWhichFrameIsNearer) {
  const auto pads = [](Time gap_end) { return std::vector{head(29), with_kept(gap(gap_end), 20)}; };
  EXPECT_EQ(decide_for(Mode::Slowest, pads(39), {29, false, 0, {}}).uses,
            (Uses{Use::Head, Use::Kept}));
  EXPECT_EQ(decide_for(Mode::Slowest, pads(38), {29, false, 0, {}}).outcome, Outcome::Wait);
}

TEST(BasePad, TakesTheTimeOfTheBase) {
  const auto d = decide_for(Mode::BasePad, {head(40), head(30)}, {}, {1, kBaseDuration});
  EXPECT_EQ(d.round.current, 30u);
  EXPECT_EQ(d.metadata_pad, 1u);
  EXPECT_EQ(d.uses, (Uses{Use::Head, Use::Head}));
  EXPECT_EQ(decide_for(Mode::BasePad, {head(40), head(30)}).uses,
            (Uses{Use::Nothing, Use::Discard}));
}

TEST(BasePad, TheWindowIsOneLessThanTheDistanceOfTwoBaseFrames) {
  const auto decide_at = [](Time other, Time duration = kBaseDuration) {
    return decide_for(Mode::BasePad, {with_kept(head(30), 20), with_kept(head(other), 5)}, {},
                      {0, duration})
        .uses[1];
  };
  EXPECT_EQ(decide_at(39), Use::Head);
  EXPECT_EQ(decide_at(40), Use::Kept);
  EXPECT_EQ(decide_at(34, 4), Use::Head);
  EXPECT_EQ(decide_at(35, 4), Use::Kept);
}

TEST(BasePad, TheWindowIsZeroForTheFirstAndForEqualBaseFrames) {
  const auto other = with_kept(head(31), 5);
  EXPECT_EQ(decide_for(Mode::BasePad, {head(30), other}).uses[1], Use::Kept);
  const auto d = decide_for(Mode::BasePad, {with_kept(head(30), 30), other});
  EXPECT_EQ(d.uses, (Uses{Use::Head, Use::Kept}));
}

TEST(BasePad, AGapOfTheBaseDiscardsFramesBeforeItsEnd) {
  EXPECT_EQ(decide_for(Mode::BasePad, {gap(50), head(49)}).uses,
            (Uses{Use::Nothing, Use::Discard}));
  EXPECT_EQ(decide_for(Mode::BasePad, {gap(50), head(50)}).uses, Uses(2, Use::Nothing));
}

TEST(BasePad, APadThatEndsAfterAFrameBeforeTheGapOfTheBaseContributesToItsRound) {
  const auto gap_of_base = decide_for(Mode::BasePad, {gap(50), head(49)});
  const auto waits = decide_for(Mode::BasePad, {gap(50), with_kept(kEnded, 49)}, gap_of_base.round);
  EXPECT_EQ(waits.outcome, Outcome::Wait);
  const auto d = decide_for(Mode::BasePad, {head(50), with_kept(kEnded, 49)}, waits.round);
  EXPECT_EQ(d.outcome, Outcome::Emit);
  EXPECT_EQ(d.uses, (Uses{Use::Head, Use::Kept}));
  EXPECT_TRUE(d.round.counted.empty());
}

TEST(BasePad, AGapBeyondTheWindowSettlesThatTheKeptFrameIsUsed) {
  const std::vector pads{with_kept(head(30), 20), with_kept(gap(40), 5)};
  EXPECT_EQ(decide_for(Mode::BasePad, pads).uses, (Uses{Use::Head, Use::Kept}));
  const std::vector near{with_kept(head(30), 20), with_kept(gap(39), 5)};
  EXPECT_EQ(decide_for(Mode::BasePad, near).outcome, Outcome::Wait);
}

TEST(Refresh, PopsNewFramesAndRepeatsTheRest) {
  const auto d = decide_for(Mode::Refresh, {with_kept(kEmpty, 10), with_kept(head(20), 5)});
  EXPECT_EQ(d.outcome, Outcome::Emit);
  EXPECT_EQ(d.uses, (Uses{Use::Kept, Use::Head}));
  EXPECT_EQ(d.metadata_pad, 1u);
}

TEST(Refresh, EmitsNothingWhileAnEndedPadNeverHadAFrame) {
  for (const PadView& other : {kEnded, kMissing, gap(99)}) {
    const auto d = decide_for(Mode::Refresh, {head(20), other});
    EXPECT_EQ(d.outcome, Outcome::Wait);
    EXPECT_EQ(d.uses, (Uses{Use::Discard, Use::Nothing}));
  }
}

TEST(Missing, PadsRepeatTheirLastFrame) {
  for (const Mode mode : kAll) {
    const auto d = decide_for(mode, {head(20), with_kept(kMissing, 5)});
    EXPECT_EQ(d.outcome, Outcome::Emit) << to_string(mode);
    EXPECT_EQ(d.uses, (Uses{Use::Head, Use::Kept})) << to_string(mode);
  }
}

TEST(Missing, AFullyRepeatedFrameIsNotSentAgain) {
  for (const Mode mode : kAll) {
    const auto d = decide_for(mode, {with_kept(kMissing, 4), with_kept(kMissing, 4)});
    EXPECT_EQ(d.outcome, Outcome::Wait) << to_string(mode);
    EXPECT_EQ(d.uses, (Uses{Use::Nothing, Use::Nothing})) << to_string(mode);
  }
}

TEST(Missing, PadsWithoutFramesLetTheOthersDrain) {
  for (const Mode mode : kAll) {
    const auto d = decide_for(mode, {head(20), kMissing});
    EXPECT_EQ(d.outcome, Outcome::Wait) << to_string(mode);
    EXPECT_EQ(d.uses, (Uses{Use::Discard, Use::Nothing})) << to_string(mode);
  }
}

TEST(Missing, WithoutTheBaseThereIsNoOutput) {
  const auto d = decide_for(Mode::BasePad, {with_kept(kMissing, 5), head(20)});
  EXPECT_EQ(d.outcome, Outcome::Wait);
  EXPECT_EQ(d.uses, (Uses{Use::Nothing, Use::Discard}));
}

// A gap delayed the round and its pad then went missing: the heads and their time are discarded.
TEST(Missing, ARoundWithoutHeadsStartsAgain) {
  for (const Mode mode : {Mode::Slowest, Mode::BasePad}) {
    const auto held_up = decide_for(mode, {head(0), gap(0)});
    EXPECT_EQ(held_up.outcome, Outcome::Wait) << to_string(mode);
    const auto given_up = decide_for(mode, {head(0), kMissing}, held_up.round);
    EXPECT_EQ(given_up.uses, (Uses{Use::Discard, Use::Nothing})) << to_string(mode);
    EXPECT_TRUE(given_up.round.need_set) << to_string(mode);
    const auto d = decide_for(mode, {with_kept(head(60), 0), head(60)}, given_up.round);
    EXPECT_EQ(d.outcome, Outcome::Emit) << to_string(mode);
    EXPECT_EQ(d.round.current, 60u) << to_string(mode);
    EXPECT_EQ(d.uses, (Uses{Use::Head, Use::Head})) << to_string(mode);
  }
}

Decision decide_late(std::vector<PadView> pads, Stamp limit) {
  return decide({Mode::Lateness, {}, limit}, {}, pads);
}

TEST(Lateness, WithoutALimitAllHeadsGoTogether) {
  const auto d = decide_late({head(5), head(900)}, {});
  EXPECT_EQ(d.outcome, Outcome::Emit);
  EXPECT_EQ(d.round.current, 5u);
  EXPECT_EQ(d.metadata_pad, 0u);
}

TEST(Lateness, TheOlderHeadIsDiscardedBeyondTheLimit) {
  EXPECT_EQ(decide_late({head(10), head(20)}, 10).outcome, Outcome::Emit);
  EXPECT_EQ(decide_late({head(10), head(21)}, 10).uses, (Uses{Use::Discard, Use::Nothing}));
  EXPECT_EQ(decide_late({head(21), head(10)}, 10).uses, (Uses{Use::Nothing, Use::Discard}));
  EXPECT_EQ(decide_late({head(21), head({})}, 0).outcome, Outcome::Emit);
}

TEST(Lateness, AGapDiscardsFramesWithoutAPartner) {
  EXPECT_EQ(decide_late({head(10), gap(20)}, {}).uses, (Uses{Use::Discard, Use::Nothing}));
  EXPECT_EQ(decide_late({head(20), gap(20)}, {}).uses, (Uses{Use::Nothing, Use::Nothing}));
  EXPECT_EQ(decide_late({head(10), gap(20)}, 10).uses, (Uses{Use::Nothing, Use::Nothing}));
}

// The mode changed within the round, while a pad ended.
TEST(Lateness, APadThatEndsDuringARoundContributesItsKeptFrame) {
  const Round begun{30, false, 0, {}};
  const auto late = [&](std::vector<PadView> pads) {
    return decide({Mode::Lateness, {}, 10}, begun, pads);
  };
  const auto second = late({head(40), with_kept(kEnded, 20)});
  EXPECT_EQ(second.outcome, Outcome::Emit);
  EXPECT_EQ(second.uses, (Uses{Use::Head, Use::Kept}));
  EXPECT_EQ(second.round.current, 40u);
  EXPECT_TRUE(second.round.need_set);
  const auto first = late({with_kept(kEnded, 20), head(40)});
  EXPECT_EQ(first.uses, (Uses{Use::Kept, Use::Head}));
  EXPECT_EQ(first.round.current, 20u);
  EXPECT_EQ(late({head(40), with_kept(kEnded, 20), kEmpty}).outcome, Outcome::Wait);
  EXPECT_EQ(late({head(40), with_kept(kEnded, 20), head(10)}).uses,
            (Uses{Use::Nothing, Use::Nothing, Use::Discard}));
}

TEST(Lateness, EndsWithTheFirstPadThatEnds) {
  EXPECT_EQ(decide_late({head(10), kEnded}, {}).outcome, Outcome::End);
  EXPECT_EQ(decide_late({head(10), kEmpty}, {}).outcome, Outcome::Wait);
}

}  // namespace policies_test
}  // namespace weir::sync
