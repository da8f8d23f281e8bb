// Metrics of trackers: MOTA and MOTP (Bernardin and Stiefelhagen 2008), IDF1 (Ristani et al. 2016),
// HOTA (Luiten et al. 2021, at the thresholds 0.05 to 0.95).
//
//   const TrackingCounts counts = count_tracks(sequence);
//   for (const Score& score : tracking_scores(counts)) print(score.name, score.value);
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/evaluate/objects.hpp"
#include "core/evaluate/scores.hpp"

namespace weir::evaluate {

struct TrackedBox {
  int64_t track = 0;  // unique in its frame
  Rectangle box;
};

struct TrackedFrame {
  std::vector<TrackedBox> truth, found;
};
using Sequence = std::vector<TrackedFrame>;

// The errors of CLEAR MOT at an overlap of 0.5.
struct ClearCounts {
  double matches = 0, missed = 0, false_found = 0, switches = 0, fragments = 0, overlap = 0;
  double tracks = 0, mostly_tracked = 0, mostly_lost = 0;  // tracked in > 80 %, in < 20 %
};

// Counts of the pairing of tracks that has the most frames in common.
struct IdentityCounts {
  double right = 0, truth = 0, found = 0;
};

inline constexpr size_t kHotaThresholds = 19;
struct HotaCounts {
  double matches = 0, missed = 0, false_found = 0;
  double association = 0;  // sum over the matches
};

// What scores are computed from. The counts of several sequences are added up.
struct TrackingCounts {
  ClearCounts clear;
  IdentityCounts identity;
  std::array<HotaCounts, kHotaThresholds> hota{};

  void add(const TrackingCounts& other, double times);
};

ClearCounts clear_counts(const Sequence& sequence);
IdentityCounts identity_counts(const Sequence& sequence);
std::array<HotaCounts, kHotaThresholds> hota_counts(const Sequence& sequence);
TrackingCounts count_tracks(const Sequence& sequence);

// HOTA, MOTA, IDF1 and the numbers that explain them.
Scores tracking_scores(const TrackingCounts& counts);
// The first three, of sequences that count several times or not at all.
Scores tracking_headline(std::span<const TrackingCounts> sequences, Times times);

// A sequence cut into parts of equal length, at most `max` and each of at least `min_frames`
// frames, so that the spread of one sequence can be estimated. One part if it is too short.
std::vector<Sequence> split_sequence(const Sequence& sequence, size_t min_frames, size_t max);

// The errors of each frame, missed and false, at an overlap of 0.5.
std::vector<size_t> errors_of_frames(const Sequence& sequence);

}  // namespace weir::evaluate
