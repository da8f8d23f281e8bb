// Metrics of trackers on sequences whose scores can be computed on paper.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/evaluate/tracking.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace weir::evaluate {
namespace tracking_test {

Rectangle at(double x) {
  return {x, 0, 10, 10};
}

double score(const Scores& scores, const std::string& name) {
  for (const Score& one : scores)
    if (one.name == name) return one.value;
  ADD_FAILURE() << "no score " << name;
  return 0;
}
double score(const Sequence& sequence, const std::string& name) {
  return score(tracking_scores(count_tracks(sequence)), name);
}

// One object for `frames` frames that is found with the track ids of `ids`; 0: not found.
Sequence one_object(const std::vector<int64_t>& ids) {
  Sequence out;
  for (const int64_t id : ids) {
    TrackedFrame frame{{{1, at(0)}}, {}};
    if (id != 0) frame.found.push_back({id, at(0)});
    out.push_back(frame);
  }
  return out;
}

TEST(Tracking, APerfectTrackerHasOnes) {
  for (const char* name : {"HOTA", "MOTA", "IDF1", "DetA", "AssA", "MOTP", "recall", "precision"})
    EXPECT_NEAR(score(one_object({7, 7, 7, 7}), name), 1, 1e-12) << name;
  EXPECT_EQ(score(one_object({7, 7, 7, 7}), "mostly tracked"), 1);
}

TEST(Tracking, ASwitchInTheMiddle) {
  // 4 frames: id 1, 1, 2, 2. MOTA = 1 - 1/4. The best pairing has 2 of 4: IDF1 = 2*2/(4+4).
  // Each match has an association of 2 / (4 + 2 - 2) = 1/2: HOTA = sqrt(1 * 1/2).
  const Sequence sequence = one_object({1, 1, 2, 2});
  EXPECT_DOUBLE_EQ(score(sequence, "MOTA"), 0.75);
  EXPECT_DOUBLE_EQ(score(sequence, "IDF1"), 0.5);
  EXPECT_NEAR(score(sequence, "AssA"), 0.5, 1e-12);
  EXPECT_NEAR(score(sequence, "HOTA"), std::sqrt(0.5), 1e-12);
  EXPECT_EQ(score(sequence, "switches"), 1);
  EXPECT_EQ(score(sequence, "fragments"), 0);
}

TEST(Tracking, AGapIsAFragmentAndNoSwitch) {
  // 5 frames, 1 missed: MOTA = 4/5; IDF1 = 2*4/(5+4); DetA = 4/5; AssA = 4/(5+4-4) = 4/5.
  const Sequence sequence = one_object({1, 1, 0, 1, 1});
  EXPECT_DOUBLE_EQ(score(sequence, "MOTA"), 0.8);
  EXPECT_DOUBLE_EQ(score(sequence, "IDF1"), 8.0 / 9);
  EXPECT_NEAR(score(sequence, "HOTA"), 0.8, 1e-12);
  EXPECT_EQ(score(sequence, "fragments"), 1);
  EXPECT_EQ(score(sequence, "switches"), 0);
  EXPECT_EQ(score(sequence, "missed"), 1);
}

TEST(Tracking, AnIdThatChangesInAGapIsASwitch) {
  EXPECT_EQ(score(one_object({1, 0, 0, 2}), "switches"), 1);
  EXPECT_EQ(score(one_object({1, 2, 1, 2}), "switches"), 3);
}

TEST(Tracking, TheExampleOfTwoFalseAndOneMissed) {
  // 3 objects of truth, 1 matched, 2 missed, 2 false: MOTA = 1 - 4/3.
  const Sequence sequence{
      {{{1, at(0)}, {2, at(100)}, {3, at(200)}}, {{1, at(0)}, {2, at(300)}, {3, at(400)}}}};
  EXPECT_NEAR(score(sequence, "MOTA"), 1 - 4.0 / 3, 1e-12);
  EXPECT_NEAR(score(sequence, "precision"), 1.0 / 3, 1e-12);
  EXPECT_NEAR(score(sequence, "recall"), 1.0 / 3, 1e-12);
  EXPECT_EQ(errors_of_frames(sequence), std::vector<size_t>{4});
}

TEST(Tracking, AMatchIsKeptWhileItFits) {
  // In the second frame id 2 overlaps better, but id 1 was matched before and still fits.
  const Sequence sequence{{{{1, at(0)}}, {{1, at(0)}}}, {{{1, at(0)}}, {{1, at(3)}, {2, at(0)}}}};
  EXPECT_EQ(score(sequence, "switches"), 0);
  EXPECT_NEAR(score(sequence, "MOTP"), (1 + 7.0 / 13) / 2, 1e-12);
}

TEST(Tracking, HotaCountsMatchesAtEachThreshold) {
  // An IoU of 7/13 = 0.538 meets 0.05 to 0.50, ten of the nineteen thresholds.
  const Sequence sequence{{{{1, at(0)}}, {{1, at(3)}}}};
  EXPECT_NEAR(score(sequence, "DetA"), 10.0 / 19, 1e-12);
  EXPECT_NEAR(score(sequence, "HOTA"), 10.0 / 19, 1e-12);
}

TEST(Tracking, HotaPrefersTracksThatBelongTogether) {
  // Both boxes are where the object is in the last frame; track 1 was there all the time.
  Sequence sequence = one_object({1, 1, 1});
  sequence.push_back({{{1, at(0)}}, {{2, at(0)}, {1, at(1)}}});
  // Track 1 has an IoU of 9/11 = 0.818 there, so it is matched up to 0.80.
  const auto counts = hota_counts(sequence);
  EXPECT_EQ(counts[9].matches, 4);   // 0.50
  EXPECT_EQ(counts[18].matches, 3);  // 0.95
}

TEST(Tracking, TracksSwapped) {
  // Two objects whose ids are swapped in the last of 3 frames: 2 switches, IDF1 = 4 of 6.
  const Sequence sequence{{{{1, at(0)}, {2, at(100)}}, {{1, at(0)}, {2, at(100)}}},
                          {{{1, at(0)}, {2, at(100)}}, {{1, at(0)}, {2, at(100)}}},
                          {{{1, at(0)}, {2, at(100)}}, {{2, at(0)}, {1, at(100)}}}};
  EXPECT_DOUBLE_EQ(score(sequence, "MOTA"), 1 - 2.0 / 6);
  EXPECT_DOUBLE_EQ(score(sequence, "IDF1"), 4.0 / 6);
  // 4 matches with 2/(3+3-2) = 1/2, 2 with 1/(3+3-1) = 1/5.
  EXPECT_NEAR(score(sequence, "AssA"), (4 * 0.5 + 2 * 0.2) / 6, 1e-12);
}

TEST(Tracking, SequencesAreAddedUp) {
  const std::vector<TrackingCounts> sequences{count_tracks(one_object({1, 1, 1, 1})),
                                              count_tracks(one_object({0, 0}))};
  EXPECT_DOUBLE_EQ(score(tracking_headline(sequences, {}), "MOTA"), 4.0 / 6);
  const std::vector<uint32_t> times{1, 0};
  EXPECT_DOUBLE_EQ(score(tracking_headline(sequences, times), "MOTA"), 1);
  const std::vector<uint32_t> second{0, 2};
  EXPECT_DOUBLE_EQ(score(tracking_headline(sequences, second), "MOTA"), 0);
}

TEST(Tracking, WithoutTruthOrFoundBoxes) {
  const Sequence empty{{{}, {}}};
  EXPECT_TRUE(std::isnan(score(empty, "MOTA")));
  EXPECT_TRUE(std::isnan(score(empty, "IDF1")));
  EXPECT_TRUE(std::isnan(score(empty, "HOTA")));
  EXPECT_DOUBLE_EQ(score(one_object({0, 0}), "HOTA"), 0);
}

TEST(PartsOf, AreOfEqualLengthAndHaveEveryFrameOnce) {
  const auto lengths = [](size_t frames, size_t min, size_t max) {
    Sequence sequence(frames);
    for (size_t i = 0; i < frames; ++i) sequence[i].found = {{static_cast<int64_t>(i), at(0)}};
    std::vector<size_t> out;
    int64_t next = 0;
    for (const Sequence& part : split_sequence(sequence, min, max)) {
      out.push_back(part.size());
      for (const TrackedFrame& frame : part) EXPECT_EQ(frame.found[0].track, next++);
    }
    EXPECT_EQ(next, static_cast<int64_t>(frames));
    return out;
  };
  using Lengths = std::vector<size_t>;
  EXPECT_EQ(lengths(12, 4, 20), (Lengths{4, 4, 4}));
  EXPECT_EQ(lengths(14, 4, 20), (Lengths{4, 5, 5}));
  EXPECT_EQ(lengths(12, 1, 3), (Lengths{4, 4, 4}));
  EXPECT_EQ(lengths(7, 4, 20), Lengths{7}) << "too short for two";
  EXPECT_EQ(lengths(3, 0, 20), (Lengths{1, 1, 1}));
  EXPECT_EQ(lengths(0, 4, 20), Lengths{0});
}

}  // namespace tracking_test
}  // namespace weir::evaluate
