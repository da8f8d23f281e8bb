// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/track/tracker.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "core/track/motion.hpp"
#include "weir/results.h"

namespace weir::track {
namespace {

constexpr double kStepsPerSecond = 30;
constexpr float kLowMatch = 0.5f;  // boxes of a low score must overlap more, as in ByteTrack's code
constexpr double kGate = 9.4877;   // 95 % of chi-squared with four degrees of freedom (DeepSORT)
constexpr float kLostHeight = 1.3f;  // most change of the height of an object that was lost
constexpr float kMaxEdge = 1e9f;     // edges beyond it are no pixels of a picture

constexpr int64_t kWithoutTrack = -1, kBeyondLimit = -2;  // in track_of_

bool can_follow(const Box& b) {
  const auto is_edge = [](float edge) { return std::abs(edge) <= kMaxEdge; };  // false for NaN
  return is_edge(b.x1) && is_edge(b.y1) && is_edge(b.x2) && is_edge(b.y2) && b.area() > 0;
}
bool is_of_like_height(const Box& a, const Box& b) {
  return a.height() <= b.height() * kLostHeight && b.height() <= a.height() * kLostHeight;
}

// Removes all but the candidates of the lowest costs, of those from `first` on.
void keep_best_candidates(size_t first, std::vector<PairCost>* all) {
  if (all->size() - first <= Tracker::kMaxCandidates) return;
  const auto begin = all->begin() + static_cast<std::ptrdiff_t>(first);
  const auto end = begin + static_cast<std::ptrdiff_t>(Tracker::kMaxCandidates);
  std::nth_element(begin, end, all->end(), [](const PairCost& a, const PairCost& b) {
    return std::tie(a.cost, a.row, a.column) < std::tie(b.cost, b.row, b.column);
  });
  all->erase(end, all->end());
}

}  // namespace

// BoT-SORT's equations 12 and 13: half of the cosine distance, if it is less and the boxes overlap
// by at least a half.
float Tracker::compute_cost(const Appearance& appearance, const Observation& box,
                            float common) const {
  constexpr float kMinOverlap = 0.5f;
  const float place = 1 - common;
  if (box.appearance.empty() || common < kMinOverlap) return place;
  const float distance = std::max(appearance.distance(box.appearance), 0.0f);
  return distance <= max_distance_ ? std::min(place, distance / 2) : place;
}

void Tracker::forget() noexcept {
  tracks_.clear();
  has_time_ = false;
}

void Tracker::predict(double seconds, const Options& options) {
  if (has_time_ && seconds < now_) tracks_.clear();
  const double passed = has_time_ ? std::max(seconds - now_, 0.0) : 0;
  now_ = seconds;
  has_time_ = true;
  std::erase_if(tracks_, [&](const Track& t) { return seconds - t.seen > options.max_age; });
  for (auto& t : tracks_) {
    t.is_matched = false;
    t.predicted = t.last;
    if (options.mode != Mode::ByteTrack) continue;
    t.motion.predict(passed * kStepsPerSecond, t.is_lost);
    t.predicted = t.motion.box();
  }
}

// Moves all tracks by the motion that those of the last frame have in common.
void Tracker::follow_camera(std::span<const Observation> boxes, const Options& options) {
  std::vector<Box> predicted, found;
  for (const auto& t : tracks_)
    if (!t.is_lost && t.number != 0) predicted.push_back(t.predicted);
  for (const auto& b : boxes)
    if (b.score >= options.high && can_follow(b.box)) found.push_back(b.box);
  const Shift shift = common_motion(predicted, found);
  const auto move = [&](Box* b) {
    b->x1 += shift.x, b->x2 += shift.x, b->y1 += shift.y, b->y2 += shift.y;
  };
  for (auto& t : tracks_) {
    t.motion.shift(shift.x, shift.y);
    move(&t.predicted);
    move(&t.last);
  }
}

// Leaves out the boxes of the lowest scores where there are too many.
size_t Tracker::leave_out_surplus(std::span<const Observation> boxes, float low) {
  std::vector<uint32_t> usable;
  for (uint32_t i = 0; i < boxes.size(); ++i)
    if (boxes[i].score >= low && can_follow(boxes[i].box)) usable.push_back(i);
  if (usable.size() <= kBoxLimit) return 0;
  const auto end = usable.begin() + static_cast<std::ptrdiff_t>(kBoxLimit);
  std::nth_element(usable.begin(), end, usable.end(), [&](uint32_t a, uint32_t b) {
    return std::tie(boxes[b].score, a) < std::tie(boxes[a].score, b);
  });
  for (auto at = end; at != usable.end(); ++at) track_of_[*at] = kBeyondLimit;
  return usable.size() - kBoxLimit;
}

// A box or a track by its group and left edge, so that only those nearby are compared.
struct Tracker::Entry {
  int64_t group;
  float left;
  uint32_t number;  // of the box or the track
  bool operator<(const Entry& other) const noexcept {
    return std::tie(group, left, number) < std::tie(other.group, other.left, other.number);
  }
};

// Boxes without a track.
struct Tracker::OpenBoxes {
  std::vector<Entry> order;
  float widest = 0;
};

template <class UseBox>
Tracker::OpenBoxes Tracker::open_boxes(std::span<const Observation> boxes, UseBox use_box) const {
  OpenBoxes out;
  for (uint32_t i = 0; i < boxes.size(); ++i) {
    const Observation& box = boxes[i];
    if (track_of_[i] != kWithoutTrack || !can_follow(box.box) || !use_box(box)) continue;
    out.order.push_back({box.group, box.box.x1, i});
    out.widest = std::max(out.widest, box.box.width());
  }
  std::sort(out.order.begin(), out.order.end());
  return out;
}

// The numbered tracks without a box.
std::vector<Tracker::Entry> Tracker::open_tracks() const {
  std::vector<Entry> out;
  for (uint32_t t = 0; t < tracks_.size(); ++t) {
    const Track& track = tracks_[t];
    if (!track.is_matched && track.number != 0) out.push_back({track.group, track.predicted.x1, t});
  }
  std::sort(out.begin(), out.end());
  return out;
}

// The boxes that overlap `box` of track `number` by at least `min`.
void Tracker::add_candidates(std::span<const Observation> boxes, const OpenBoxes& open,
                             uint32_t number, const Box& box, float min,
                             std::vector<PairCost>* out) {
  const Track& track = tracks_[number];
  const size_t first = out->size();
  const auto compare = [&](uint32_t at) {
    const Observation& other = boxes[at];
    const float common = overlap(box, other.box);
    const bool must_be_like = must_keep_height_ && track.is_lost;
    if (common > 0 && common >= min && (!must_be_like || is_of_like_height(box, other.box)))
      out->push_back({number, at, compute_cost(track.appearance, other, common)});
  };
  const auto begin = open.order.begin(), end = open.order.end();
  auto right = std::lower_bound(begin, end, Entry{track.group, box.x1, 0});
  auto left = right;  // entries to compare are at right, and before left
  for (size_t compared = 0; compared < kMaxCompared; ++compared, ++compared_) {
    const bool has_right = right != end && right->group == track.group && right->left < box.x2;
    const bool has_left = left != begin && std::prev(left)->group == track.group &&
                          std::prev(left)->left >= box.x1 - open.widest;
    if (!has_right && !has_left) break;
    const bool goes_right =
        !has_left || (has_right && right->left - box.x1 <= box.x1 - std::prev(left)->left);
    compare(goes_right ? (right++)->number : (--left)->number);
  }
  keep_best_candidates(first, out);
}

// Gives tracks the boxes that fit best together.
void Tracker::take(std::span<const PairCost> candidates) {
  candidates_ += candidates.size();
  for (const auto& pair : assign(candidates)) {
    track_of_[pair.column] = pair.row;
    tracks_[pair.row].is_matched = true;
  }
}

template <class UseTrack, class UseBox>
void Tracker::match(std::span<const Observation> boxes, Place place, float min, UseTrack use_track,
                    UseBox use_box) {
  const OpenBoxes open = open_boxes(boxes, use_box);
  std::vector<PairCost> candidates;
  for (uint32_t t = 0; t < tracks_.size(); ++t) {
    const Track& track = tracks_[t];
    if (track.is_matched || !use_track(track)) continue;
    add_candidates(boxes, open, t, place == Place::Last ? track.last : track.predicted, min,
                   &candidates);
  }
  take(candidates);
}

// The tracks of `open` that look like box `number`, of those that their predictions allow.
void Tracker::add_similar_tracks(std::span<const Entry> open, const Observation& box,
                                 uint32_t number, float max, std::vector<PairCost>* out) {
  std::vector<PairCost> near;
  const auto middle = std::lower_bound(open.begin(), open.end(), Entry{box.group, box.box.x1, 0});
  constexpr auto kReach = static_cast<std::ptrdiff_t>(kMaxCompared / 2);
  const auto last = middle + std::min(open.end() - middle, kReach);
  for (auto at = middle - std::min(middle - open.begin(), kReach); at != last; ++at) {
    if (at->group != box.group) continue;
    ++compared_;
    const auto distance = static_cast<float>(tracks_[at->number].motion.distance(box.box));
    if (distance <= kGate) near.push_back({at->number, number, distance});
  }
  keep_best_candidates(0, &near);
  for (PairCost& candidate : near) {
    candidate.cost = tracks_[candidate.row].appearance.distance(box.appearance);
    if (candidate.cost <= max) out->push_back(candidate);
  }
}

// Numbered tracks without a box take the one that looks most like them, of those that the
// prediction allows: DeepSORT (arXiv 1703.07402), equations 1 to 4.
void Tracker::match_appearance(std::span<const Observation> boxes, const Options& options) {
  const std::vector<Entry> open = open_tracks();
  if (open.empty()) return;
  std::vector<PairCost> candidates;
  for (uint32_t b = 0; b < boxes.size(); ++b) {
    const Observation& box = boxes[b];
    if (track_of_[b] != kWithoutTrack || box.appearance.empty() || !can_follow(box.box) ||
        !(box.score >= options.high))
      continue;
    add_similar_tracks(open, box, b, options.appearance, &candidates);
  }
  take(candidates);
}

void Tracker::begin_tracks(std::span<const Observation> boxes, const Options& options) {
  for (size_t i = 0; i < boxes.size(); ++i) {
    if (track_of_[i] != kWithoutTrack || !can_follow(boxes[i].box) ||
        !(boxes[i].score >= options.high))
      continue;
    track_of_[i] = static_cast<int64_t>(tracks_.size());
    tracks_.push_back({.motion = BoxMotion(boxes[i].box),
                       .appearance = {},
                       .last = boxes[i].box,
                       .predicted = boxes[i].box,
                       .group = boxes[i].group,
                       .hits = 0,
                       .seen = now_,
                       .is_matched = true});
  }
}

// Numbers repeat after 2^24 - 1 of them; those in use are skipped.
uint32_t Tracker::next_number() {
  const auto is_used = [&](const Track& t) { return t.number == last_number_; };
  do {
    last_number_ = last_number_ + 1 < WEIR_RESULTS_TRACK_LIMIT ? last_number_ + 1 : 1;
  } while (given_ >= WEIR_RESULTS_TRACK_LIMIT - 1 &&
           std::any_of(tracks_.begin(), tracks_.end(), is_used));
  ++given_;
  return last_number_;
}

// Tracks without a box become lost, those without a number are removed.
void Tracker::finish_tracks() {
  for (auto& t : tracks_) t.is_lost = !t.is_matched;
  std::erase_if(tracks_, [](const Track& t) { return t.is_lost && t.number == 0; });
  const auto lost =
      std::count_if(tracks_.begin(), tracks_.end(), [](const Track& t) { return t.is_lost; });
  if (static_cast<size_t>(lost) <= kLostLimit) return;
  std::vector<double> times;
  for (const auto& t : tracks_)
    if (t.is_lost) times.push_back(t.seen);
  const auto oldest = times.begin() + static_cast<std::ptrdiff_t>(times.size() - kLostLimit);
  std::nth_element(times.begin(), oldest, times.end());
  const double kept_from = *oldest;
  size_t surplus = times.size() - kLostLimit;
  for (const bool at_border : {false, true})
    std::erase_if(tracks_, [&](const Track& t) {
      const bool goes =
          t.is_lost && surplus > 0 && (at_border ? t.seen <= kept_from : t.seen < kept_from);
      surplus -= goes;
      return goes;
    });
}

const std::vector<uint32_t>& Tracker::follow(std::span<const Observation> boxes, double seconds,
                                             const Options& options) {
  must_keep_height_ = options.mode == Mode::ByteTrack;
  max_distance_ = options.appearance;
  compared_ = candidates_ = 0;
  predict(seconds, options);
  track_of_.assign(boxes.size(), kWithoutTrack);
  left_out_ = leave_out_surplus(boxes, std::min(options.low, options.high));
  if (options.mode == Mode::ByteTrack && options.camera_motion) follow_camera(boxes, options);
  const auto is_high = [&](const Observation& b) { return b.score >= options.high; };
  const auto is_low = [&](const Observation& b) {
    return b.score >= options.low && b.score < options.high;
  };
  const auto is_numbered = [](const Track& t) { return t.number != 0; };
  const auto is_new = [](const Track& t) { return t.number == 0; };
  match(boxes, Place::Predicted, options.match, is_numbered, is_high);
  if (options.mode == Mode::ByteTrack) {
    const auto was_seen = [](const Track& t) { return t.number != 0 && !t.is_lost; };
    match_appearance(boxes, options);
    match(boxes, Place::Predicted, std::max(kLowMatch, options.match), was_seen, is_low);
    match(boxes, Place::Last, options.match, is_numbered, is_high);
  }
  match(boxes, Place::Predicted, options.match, is_new, is_high);
  begin_tracks(boxes, options);
  numbers_.assign(boxes.size(), 0);
  for (size_t i = 0; i < boxes.size(); ++i) {
    if (track_of_[i] < 0) continue;
    Track& t = tracks_[static_cast<size_t>(track_of_[i])];
    if (t.hits > 0) t.motion.correct(boxes[i].box);
    if (boxes[i].score >= options.high) t.appearance.add(boxes[i].appearance);
    t.hits = std::min(t.hits + 1, UINT32_MAX - 1);
    t.last = boxes[i].box;
    t.seen = now_;
    if (t.number == 0 && t.hits >= options.min_hits) t.number = next_number();
    numbers_[i] = t.number;
  }
  finish_tracks();
  return numbers_;
}

}  // namespace weir::track
