// Adds up counts and computes scores from them.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/evaluate/tracking.hpp"

#include <algorithm>
#include <cmath>

namespace weir::evaluate {
namespace {

struct Hota {
  double hota = 0, detection = 0, association = 0;
};

// The means over the thresholds.
Hota hota_of(const TrackingCounts& counts) {
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
  return {{"HOTA", hota_of(counts).hota},
          {"MOTA", ratio(clear.matches - clear.false_found - clear.switches, boxes)},
          {"IDF1", ratio(2 * identity.right, identity.truth + identity.found)}};
}

}  // namespace

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
  const Hota hota = hota_of(counts);
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
  for (size_t i = 0; i < sequences.size(); ++i) sum.add(sequences[i], times_of(times, i));
  return headline(sum);
}

std::vector<Sequence> parts_of(const Sequence& sequence, size_t least_frames, size_t most) {
  const size_t count =
      std::clamp<size_t>(sequence.size() / std::max<size_t>(least_frames, 1), 1, most);
  const auto at = [&](size_t part) {
    return sequence.begin() + static_cast<ptrdiff_t>(sequence.size() * part / count);
  };
  std::vector<Sequence> out;
  for (size_t i = 0; i < count; ++i) out.emplace_back(at(i), at(i + 1));
  return out;
}

}  // namespace weir::evaluate
