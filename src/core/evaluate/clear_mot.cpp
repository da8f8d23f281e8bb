// CLEAR MOT: matches boxes frame by frame, and keeps a match as long as it fits.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <optional>

#include "core/evaluate/track_numbers.hpp"

namespace weir::evaluate {
namespace {

struct Track {
  std::optional<size_t> found;     // the last track that it was matched with
  std::optional<size_t> previous;  // that of the frame before
  size_t matches = 0;
};

// The matches of a frame: those of the frame before that still fit, and the best others.
std::vector<std::optional<size_t>> match(const NumberedFrame& frame,
                                         const std::vector<Track>& tracks) {
  constexpr double kKept = 1000;  // more than any sum of overlaps in a frame
  track::Matrix values(frame.truth.size(), frame.found.size());
  for (size_t t = 0; t < frame.truth.size(); ++t)
    for (size_t f = 0; f < frame.found.size(); ++f) {
      const double overlap = frame.overlaps.at(t, f);
      if (overlap < kLeastOverlap) continue;
      const bool is_kept = tracks[frame.truth[t]].previous == frame.found[f];
      values.at(t, f) = overlap + (is_kept ? kKept : 0);
    }
  auto out = track::best_assignment(values);
  for (size_t t = 0; t < out.size(); ++t)
    if (out[t] && values.at(t, *out[t]) == 0) out[t].reset();
  return out;
}

void count_frame(const NumberedFrame& frame, std::vector<Track>* tracks, ClearCounts* counts) {
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

}  // namespace

ClearCounts clear_counts(const Sequence& sequence) {
  constexpr double kMostly = 0.8, kHardly = 0.2;
  const NumberedSequence numbered = number_tracks(sequence);
  std::vector<Track> tracks(numbered.truth_lengths.size());
  ClearCounts out;
  for (const NumberedFrame& frame : numbered.frames) count_frame(frame, &tracks, &out);
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
  const NumberedSequence numbered = number_tracks(sequence);
  std::vector<Track> tracks(numbered.truth_lengths.size());
  std::vector<size_t> out;
  for (const NumberedFrame& frame : numbered.frames) {
    ClearCounts counts;
    count_frame(frame, &tracks, &counts);
    out.push_back(static_cast<size_t>(counts.missed + counts.false_found + counts.switches));
  }
  return out;
}

}  // namespace weir::evaluate
