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

double threshold_at(size_t index) noexcept {
  return 0.05 * static_cast<double>(index + 1);
}

// How well each track of the truth and each found one agree, by the overlaps of all their boxes.
track::Matrix agreement(const NumberedSequence& numbered) {
  track::Matrix out(numbered.truth_lengths.size(), numbered.found_lengths.size());
  for (const NumberedFrame& frame : numbered.frames) {
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
        if (all > kRounding) out.at(frame.truth[t], frame.found[f]) += overlap / all;
      }
  }
  for (size_t t = 0; t < out.rows(); ++t)
    for (size_t f = 0; f < out.columns(); ++f) {
      const double lengths =
          static_cast<double>(numbered.truth_lengths[t] + numbered.found_lengths[f]);
      out.at(t, f) /= lengths - out.at(t, f);
    }
  return out;
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
    track::Matrix values(frame.truth.size(), frame.found.size());
    for (size_t t = 0; t < frame.truth.size(); ++t)
      for (size_t f = 0; f < frame.found.size(); ++f)
        values.at(t, f) = agreements.at(frame.truth[t], frame.found[f]) * frame.overlaps.at(t, f);
    const auto matches = track::best_assignment(values);
    for (size_t a = 0; a < kHotaThresholds; ++a) {
      double matched = 0;
      for (size_t t = 0; t < matches.size(); ++t) {
        if (!matches[t] || frame.overlaps.at(t, *matches[t]) < threshold_at(a) - kRounding)
          continue;
        ++matched;
        ++pairs[frame.truth[t] * columns + frame.found[*matches[t]]][a];
      }
      out[a].matches += matched;
      out[a].missed += static_cast<double>(frame.truth.size()) - matched;
      out[a].false_found += static_cast<double>(frame.found.size()) - matched;
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
