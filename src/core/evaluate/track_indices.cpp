// Numbers tracks in the order in which they begin.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/evaluate/track_indices.hpp"

#include <unordered_map>

#include "core/evaluate/similarity.hpp"

namespace weir::evaluate {
namespace {

class TrackIndices {
 public:
  std::vector<size_t> of(const std::vector<TrackedBox>& boxes) {
    std::vector<size_t> out;
    for (const TrackedBox& box : boxes) {
      const auto [place, is_new] = numbers_.try_emplace(box.track, lengths.size());
      if (is_new) lengths.push_back(0);
      ++lengths[place->second];
      out.push_back(place->second);
    }
    return out;
  }
  std::vector<size_t> lengths;

 private:
  std::unordered_map<int64_t, size_t> numbers_;
};

}  // namespace

IndexedSequence index_tracks(const Sequence& sequence) {
  IndexedSequence out;
  TrackIndices truth, found;
  for (const TrackedFrame& frame : sequence) {
    track::Matrix overlaps(frame.truth.size(), frame.found.size());
    for (size_t t = 0; t < frame.truth.size(); ++t)
      for (size_t f = 0; f < frame.found.size(); ++f)
        overlaps.at(t, f) = overlap(frame.truth[t].box, frame.found[f].box);
    out.frames.push_back({truth.of(frame.truth), found.of(frame.found), std::move(overlaps)});
  }
  out.truth_lengths = std::move(truth.lengths);
  out.found_lengths = std::move(found.lengths);
  return out;
}

}  // namespace weir::evaluate
