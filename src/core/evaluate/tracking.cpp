// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/evaluate/tracking.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <unordered_map>

#include "core/evaluate/track_indices.hpp"

namespace weir::evaluate {
namespace {

struct Track {
  std::optional<size_t> found;     // the last track that it was matched with
  std::optional<size_t> previous;  // that of the frame before
  size_t matches = 0;
};

// The matches of a frame: those of the frame before that still fit, and the best others.
std::vector<std::optional<size_t>> match(const IndexedFrame& frame,
                                         const std::vector<Track>& tracks) {
  constexpr double kKept = 1000;  // more than any sum of overlaps in a frame
  track::Matrix values(frame.truth.size(), frame.found.size());
  for (size_t t = 0; t < frame.truth.size(); ++t)
    for (size_t f = 0; f < frame.found.size(); ++f) {
      const double overlap = frame.overlaps.at(t, f);
      if (overlap < kMinOverlap) continue;
      const bool is_kept = tracks[frame.truth[t]].previous == frame.found[f];
      values.at(t, f) = overlap + (is_kept ? kKept : 0);
    }
  auto out = track::best_assignment(values);
  for (size_t t = 0; t < out.size(); ++t)
    if (out[t] && values.at(t, *out[t]) == 0) out[t].reset();
  return out;
}

void count_frame(const IndexedFrame& frame, std::vector<Track>* tracks, ClearCounts* counts) {
  const auto matches = match(frame, *tracks);
  double matched = 0;
  const std::vector<Track> before = *tracks;
  for (Track& track : *tracks) track.previous.reset();
  for (size_t t = 0; t < matches.size(); ++t) {
    if (!matches[t]) continue;
    Track& track = (*tracks)[frame.truth[t]];
    const size_t found = frame.found[*matches[t]];
    if (track.found && *track.found != found) ++counts->switches;
    if (track.matches > 0 && !before[frame.truth[t]].previous) ++counts->fragments;
    track.found = track.previous = found;
    ++track.matches;
    ++matched;
    counts->overlap += frame.overlaps.at(t, *matches[t]);
  }
  counts->matches += matched;
  counts->missed += static_cast<double>(frame.truth.size()) - matched;
  counts->false_found += static_cast<double>(frame.found.size()) - matched;
}

constexpr double kRounding = std::numeric_limits<double>::epsilon();

double hota_threshold_at(size_t index) noexcept {
  return 0.05 * static_cast<double>(index + 1);
}

// Adds for each pair of boxes of a frame how much of the overlaps of both is the pair's own.
void add_agreement(const IndexedFrame& frame, track::Matrix* out) {
  std::vector<double> of_truth(frame.truth.size()), of_found(frame.found.size());
  for (size_t t = 0; t < frame.truth.size(); ++t)
    for (size_t f = 0; f < frame.found.size(); ++f) {
      of_truth[t] += frame.overlaps.at(t, f);
      of_found[f] += frame.overlaps.at(t, f);
    }
  for (size_t t = 0; t < frame.truth.size(); ++t)
    for (size_t f = 0; f < frame.found.size(); ++f) {
      const double overlap = frame.overlaps.at(t, f);
      const double all = of_truth[t] + of_found[f] - overlap;
      if (all > kRounding) out->at(frame.truth[t], frame.found[f]) += overlap / all;
    }
}

// How well each track of the truth and each found one agree, by the overlaps of all their boxes.
track::Matrix agreement(const IndexedSequence& numbered) {
  track::Matrix out(numbered.truth_lengths.size(), numbered.found_lengths.size());
  for (const IndexedFrame& frame : numbered.frames) add_agreement(frame, &out);
  for (size_t t = 0; t < out.rows(); ++t)
    for (size_t f = 0; f < out.columns(); ++f) {
      const double lengths =
          static_cast<double>(numbered.truth_lengths[t] + numbered.found_lengths[f]);
      out.at(t, f) /= lengths - out.at(t, f);
    }
  return out;
}

// Matches the boxes of a frame. Tracks that agree over the whole sequence are preferred.
std::vector<std::optional<size_t>> match(const IndexedFrame& frame,
                                         const track::Matrix& agreements) {
  track::Matrix values(frame.truth.size(), frame.found.size());
  for (size_t t = 0; t < frame.truth.size(); ++t)
    for (size_t f = 0; f < frame.found.size(); ++f)
      values.at(t, f) = agreements.at(frame.truth[t], frame.found[f]) * frame.overlaps.at(t, f);
  return track::best_assignment(values);
}

// Frames in which two tracks were matched, for each threshold.
using PairCounts = std::array<double, kHotaThresholds>;

struct Hota {
  double hota = 0, detection = 0, association = 0;
};

// The means over the thresholds.
Hota compute_hota(const TrackingCounts& counts) {
  Hota out;
  for (const HotaCounts& one : counts.hota) {
    const double all = one.matches + one.missed + one.false_found;
    if (all == 0) return {kUndefined, kUndefined, kUndefined};
    const double detection = one.matches / all;
    const double association = one.matches > 0 ? one.association / one.matches : 0;
    out.hota += std::sqrt(detection * association);
    out.detection += detection;
    out.association += association;
  }
  out.hota /= kHotaThresholds;
  out.detection /= kHotaThresholds;
  out.association /= kHotaThresholds;
  return out;
}

Scores headline(const TrackingCounts& counts) {
  const ClearCounts& clear = counts.clear;
  const IdentityCounts& identity = counts.identity;
  const double boxes = clear.matches + clear.missed;
  return {{"HOTA", compute_hota(counts).hota},
          {"MOTA", ratio(clear.matches - clear.false_found - clear.switches, boxes)},
          {"IDF1", ratio(2 * identity.right, identity.truth + identity.found)}};
}

}  // namespace

ClearCounts clear_counts(const Sequence& sequence) {
  constexpr double kMostly = 0.8, kHardly = 0.2;
  const IndexedSequence numbered = index_tracks(sequence);
  std::vector<Track> tracks(numbered.truth_lengths.size());
  ClearCounts out;
  for (const IndexedFrame& frame : numbered.frames) count_frame(frame, &tracks, &out);
  out.tracks = static_cast<double>(tracks.size());
  for (size_t t = 0; t < tracks.size(); ++t) {
    const double part =
        static_cast<double>(tracks[t].matches) / static_cast<double>(numbered.truth_lengths[t]);
    if (part > kMostly) ++out.mostly_tracked;
    if (part < kHardly) ++out.mostly_lost;
  }
  return out;
}

std::vector<size_t> errors_of_frames(const Sequence& sequence) {
  const IndexedSequence numbered = index_tracks(sequence);
  std::vector<Track> tracks(numbered.truth_lengths.size());
  std::vector<size_t> out;
  for (const IndexedFrame& frame : numbered.frames) {
    ClearCounts counts;
    count_frame(frame, &tracks, &counts);
    out.push_back(static_cast<size_t>(counts.missed + counts.false_found + counts.switches));
  }
  return out;
}

IdentityCounts identity_counts(const Sequence& sequence) {
  const IndexedSequence numbered = index_tracks(sequence);
  track::Matrix common(numbered.truth_lengths.size(), numbered.found_lengths.size());
  for (const IndexedFrame& frame : numbered.frames)
    for (size_t t = 0; t < frame.truth.size(); ++t)
      for (size_t f = 0; f < frame.found.size(); ++f)
        if (frame.overlaps.at(t, f) >= kMinOverlap) ++common.at(frame.truth[t], frame.found[f]);
  IdentityCounts out;
  const auto pairs = track::best_assignment(common);
  for (size_t t = 0; t < pairs.size(); ++t)
    if (pairs[t]) out.right += common.at(t, *pairs[t]);
  const auto sum = [](const std::vector<size_t>& lengths) {
    return static_cast<double>(std::accumulate(lengths.begin(), lengths.end(), size_t{0}));
  };
  out.truth = sum(numbered.truth_lengths);
  out.found = sum(numbered.found_lengths);
  return out;
}

std::array<HotaCounts, kHotaThresholds> hota_counts(const Sequence& sequence) {
  const IndexedSequence numbered = index_tracks(sequence);
  const track::Matrix agreements = agreement(numbered);
  const size_t columns = agreements.columns();
  std::array<HotaCounts, kHotaThresholds> out{};
  std::unordered_map<size_t, PairCounts> pairs;  // by truth * columns + found
  for (const IndexedFrame& frame : numbered.frames) {
    for (HotaCounts& counts : out) {
      counts.missed += static_cast<double>(frame.truth.size());
      counts.false_found += static_cast<double>(frame.found.size());
    }
    const auto matches = match(frame, agreements);
    for (size_t t = 0; t < matches.size(); ++t) {
      if (!matches[t]) continue;
      const double overlap = frame.overlaps.at(t, *matches[t]);
      PairCounts& pair = pairs[frame.truth[t] * columns + frame.found[*matches[t]]];
      for (size_t a = 0; a < kHotaThresholds && overlap >= hota_threshold_at(a) - kRounding; ++a) {
        ++out[a].matches, --out[a].missed, --out[a].false_found;
        ++pair[a];
      }
    }
  }
  for (const auto& [pair, counts] : pairs) {
    const auto lengths = static_cast<double>(numbered.truth_lengths[pair / columns] +
                                             numbered.found_lengths[pair % columns]);
    for (size_t a = 0; a < kHotaThresholds; ++a)
      out[a].association += counts[a] * counts[a] / std::max(1.0, lengths - counts[a]);
  }
  return out;
}

void TrackingCounts::add(const TrackingCounts& other, double times) {
  const auto plus = [times](double* sum, double value) { *sum += times * value; };
  plus(&clear.matches, other.clear.matches);
  plus(&clear.missed, other.clear.missed);
  plus(&clear.false_found, other.clear.false_found);
  plus(&clear.switches, other.clear.switches);
  plus(&clear.fragments, other.clear.fragments);
  plus(&clear.overlap, other.clear.overlap);
  plus(&clear.tracks, other.clear.tracks);
  plus(&clear.mostly_tracked, other.clear.mostly_tracked);
  plus(&clear.mostly_lost, other.clear.mostly_lost);
  plus(&identity.right, other.identity.right);
  plus(&identity.truth, other.identity.truth);
  plus(&identity.found, other.identity.found);
  for (size_t a = 0; a < kHotaThresholds; ++a) {
    plus(&hota[a].matches, other.hota[a].matches);
    plus(&hota[a].missed, other.hota[a].missed);
    plus(&hota[a].false_found, other.hota[a].false_found);
    plus(&hota[a].association, other.hota[a].association);
  }
}

TrackingCounts count_tracks(const Sequence& sequence) {
  return {clear_counts(sequence), identity_counts(sequence), hota_counts(sequence)};
}

Scores tracking_scores(const TrackingCounts& counts) {
  const ClearCounts& clear = counts.clear;
  const IdentityCounts& identity = counts.identity;
  const Hota hota = compute_hota(counts);
  Scores out = headline(counts);
  out.insert(out.end(), {{"DetA", hota.detection},
                         {"AssA", hota.association},
                         {"IDP", ratio(identity.right, identity.found)},
                         {"IDR", ratio(identity.right, identity.truth)},
                         {"MOTP", ratio(clear.overlap, clear.matches)},
                         {"recall", ratio(clear.matches, clear.matches + clear.missed)},
                         {"precision", ratio(clear.matches, clear.matches + clear.false_found)},
                         {"missed", clear.missed},
                         {"false", clear.false_found},
                         {"switches", clear.switches},
                         {"fragments", clear.fragments},
                         {"tracks", clear.tracks},
                         {"mostly tracked", clear.mostly_tracked},
                         {"mostly lost", clear.mostly_lost}});
  return out;
}

Scores tracking_headline(std::span<const TrackingCounts> sequences, Times times) {
  TrackingCounts sum;
  for (size_t i = 0; i < sequences.size(); ++i) sum.add(sequences[i], count_times(times, i));
  return headline(sum);
}

std::vector<Sequence> split_sequence(const Sequence& sequence, size_t min_frames, size_t max) {
  const size_t count =
      std::clamp<size_t>(sequence.size() / std::max<size_t>(min_frames, 1), 1, max);
  const auto at = [&](size_t part) {
    return sequence.begin() + static_cast<ptrdiff_t>(sequence.size() * part / count);
  };
  std::vector<Sequence> out;
  for (size_t i = 0; i < count; ++i) out.emplace_back(at(i), at(i + 1));
  return out;
}

}  // namespace weir::evaluate
