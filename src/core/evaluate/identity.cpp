// IDF1: pairs whole tracks so that they have as many frames in common as possible.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <numeric>

#include "core/evaluate/track_numbers.hpp"

namespace weir::evaluate {

IdentityCounts identity_counts(const Sequence& sequence) {
  const NumberedSequence numbered = number_tracks(sequence);
  track::Matrix common(numbered.truth_lengths.size(), numbered.found_lengths.size());
  for (const NumberedFrame& frame : numbered.frames)
    for (size_t t = 0; t < frame.truth.size(); ++t)
      for (size_t f = 0; f < frame.found.size(); ++f)
        if (frame.overlaps.at(t, f) >= kLeastOverlap) ++common.at(frame.truth[t], frame.found[f]);
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

}  // namespace weir::evaluate
