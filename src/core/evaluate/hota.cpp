// HOTA: matches each frame so that tracks that belong together over the whole sequence are
// preferred, then weighs each match by how well its two tracks agree.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <limits>
#include <unordered_map>

#include "core/evaluate/track_numbers.hpp"

namespace weir::evaluate {
namespace {

constexpr double kRounding = std::numeric_limits<double>::epsilon();

double hota_threshold_at(size_t index) noexcept {
  return 0.05 * static_cast<double>(index + 1);
}

// Adds for each pair of boxes of a frame how much of the overlaps of both is the pair's own.
void add_agreement(const NumberedFrame& frame, track::Matrix* out) {
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
track::Matrix agreement(const NumberedSequence& numbered) {
  track::Matrix out(numbered.truth_lengths.size(), numbered.found_lengths.size());
  for (const NumberedFrame& frame : numbered.frames) add_agreement(frame, &out);
  for (size_t t = 0; t < out.rows(); ++t)
    for (size_t f = 0; f < out.columns(); ++f) {
      const double lengths =
          static_cast<double>(numbered.truth_lengths[t] + numbered.found_lengths[f]);
      out.at(t, f) /= lengths - out.at(t, f);
    }
  return out;
}

// Matches the boxes of a frame. Tracks that agree over the whole sequence are preferred.
std::vector<std::optional<size_t>> match(const NumberedFrame& frame,
                                         const track::Matrix& agreements) {
  track::Matrix values(frame.truth.size(), frame.found.size());
  for (size_t t = 0; t < frame.truth.size(); ++t)
    for (size_t f = 0; f < frame.found.size(); ++f)
      values.at(t, f) = agreements.at(frame.truth[t], frame.found[f]) * frame.overlaps.at(t, f);
  return track::best_assignment(values);
}

// Frames in which two tracks were matched, for each threshold.
using PairCounts = std::array<double, kHotaThresholds>;

}  // namespace

std::array<HotaCounts, kHotaThresholds> hota_counts(const Sequence& sequence) {
  const NumberedSequence numbered = number_tracks(sequence);
  const track::Matrix agreements = agreement(numbered);
  const size_t columns = agreements.columns();
  std::array<HotaCounts, kHotaThresholds> out{};
  std::unordered_map<size_t, PairCounts> pairs;  // by truth * columns + found
  for (const NumberedFrame& frame : numbered.frames) {
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

}  // namespace weir::evaluate
