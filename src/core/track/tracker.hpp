// Tracker: gives objects the same number from frame to frame, as ByteTrack does.
//
//   Tracker tracker;
//   const auto& numbers = tracker.follow(boxes, seconds, {});
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/track/appearance.hpp"
#include "core/track/assignment.hpp"
#include "core/track/motion.hpp"

namespace weir::track {

struct Observation {
  Box box{};
  float score = 1;
  int64_t group = 0;                    // boxes of different groups are different objects
  std::span<const float> appearance{};  // a vector of a network; empty = unknown
};

enum class Mode : int { ByteTrack, Iou };

struct Options {
  Mode mode = Mode::ByteTrack;
  float high = 0.5f;          // least score of boxes that are matched first, and that begin tracks
  float low = 0.1f;           // least score of boxes that continue tracks
  float match = 0.2f;         // least intersection over union of a track and its box
  double max_age = 1;         // seconds that a track lives without a box
  bool camera_motion = true;  // follow a motion that all objects have in common
  float appearance = 0.25f;   // most cosine distance of a track and the vector of its box
  uint32_t min_hits = 2;      // frames with a box before an object gets its number
};

// ByteTrack (arXiv 2110.06864): boxes of a high score are matched with the predicted boxes of the
// tracks, then those of a low score with the tracks that are left. The tracks that are still left
// are matched by their last observed box, as OC-SORT (arXiv 2203.14360) recovers them. Before all
// this, the motion that tracks have in common moves them, as that of the camera. A lost track
// takes only boxes of nearly its height. Mode Iou matches last boxes only, without prediction. Used
// by one thread at a time.
class Tracker {
 public:
  // Lost tracks beyond this many are forgotten, those lost for the longest time first.
  static constexpr size_t kLostLimit = 4096;
  // Boxes of a frame beyond this many have no number: those of the lowest scores.
  static constexpr size_t kBoxLimit = 10000;
  // A track is compared with at most so many boxes at a time, and a box with so many tracks: those
  // whose left edges are near. Of these, so many of the best may be assigned.
  static constexpr size_t kMaxCompared = 1024, kMaxCandidates = 64;

  // The number of each box, in their order; 0 = none. `seconds` is the time of the frame: equal
  // times are no motion; a time before the last one forgets all tracks. Boxes without area or that
  // are not finite have no number. Valid until the next call.
  const std::vector<uint32_t>& follow(std::span<const Observation> boxes, double seconds,
                                      const Options& options);
  void forget() noexcept;  // all tracks; their numbers are not given again
  size_t tracks() const noexcept { return tracks_.size(); }
  uint64_t numbers_given() const noexcept { return given_; }
  // Boxes of the last frame beyond the limit.
  size_t left_out() const noexcept { return left_out_; }
  // Pairs of a track and a box that the last frame compared, and those that could be assigned.
  size_t compared() const noexcept { return compared_; }
  size_t candidates() const noexcept { return candidates_; }

 private:
  struct Track {
    BoxMotion motion;
    Appearance appearance;
    Box last{}, predicted{};
    int64_t group = 0;
    uint32_t number = 0, hits = 1;
    double seen = 0;
    bool is_lost = false, is_matched = false;
  };
  enum class Place { Predicted, Last };
  struct Entry;
  struct OpenBoxes;

  float compute_cost(const Appearance& appearance, const Observation& box, float common) const;
  void predict(double seconds, const Options& options);
  void follow_camera(std::span<const Observation> boxes, const Options& options);
  size_t leave_out_surplus(std::span<const Observation> boxes, float low);
  template <class UseBox>
  OpenBoxes open_boxes(std::span<const Observation> boxes, UseBox use_box) const;
  std::vector<Entry> open_tracks() const;
  void add_candidates(std::span<const Observation> boxes, const OpenBoxes& open, uint32_t number,
                      const Box& box, float min, std::vector<PairCost>* out);
  void take(std::span<const PairCost> candidates);
  template <class UseTrack, class UseBox>
  void match(std::span<const Observation> boxes, Place place, float min, UseTrack use_track,
             UseBox use_box);
  void add_similar_tracks(std::span<const Entry> open, const Observation& box, uint32_t number,
                          float max, std::vector<PairCost>* out);
  void match_appearance(std::span<const Observation> boxes, const Options& options);
  void begin_tracks(std::span<const Observation> boxes, const Options& options);
  void finish_tracks();
  uint32_t next_number();

  std::vector<Track> tracks_;
  std::vector<uint32_t> numbers_;
  std::vector<int64_t> track_of_;  // of each box; negative = none
  size_t left_out_ = 0, compared_ = 0, candidates_ = 0;
  double now_ = 0;
  bool has_time_ = false;
  float max_distance_ = 0;
  bool must_keep_height_ = false;  // of lost tracks; not in mode Iou
  uint32_t last_number_ = 0;
  uint64_t given_ = 0;
};

}  // namespace weir::track
