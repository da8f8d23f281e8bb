// ZoneCounter: follows objects through zones from frame to frame: who is where, for how long, how
// fast, and what has been counted.
//
//   ZoneCounter counter(zones, {});
//   counter.update(time, objects);
//   for (const Event& event : counter.events()) report(event);
//
// One thread at a time. Memory is bounded by the limits below, not by the length of the stream.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

#include "core/zone/zone.hpp"

namespace weir::zone {

inline constexpr int64_t kNoTime = INT64_MIN;
inline constexpr int32_t kNoClass = -1;
inline constexpr size_t kTrackLimit = 10000;  // tracks that are followed at a time
inline constexpr size_t kStayLimit = 100;     // areas in which a track is at a time; lines near it
inline constexpr size_t kEventLimit = 65536;  // events of a frame
inline constexpr size_t kClassLimit = 65536;  // classes that are counted apart, of all zones
inline constexpr size_t kSampleLimit = 16;    // positions from which a speed is computed

// An object of a frame.
struct Sighting {
  uint32_t group = 0;  // tracks of different groups are different
  uint32_t track = 0;  // 0: not followed; it only counts as inside
  int32_t class_index = kNoClass;
  Box box{};
  float rotation = 0;
};

struct Speed {
  float pixels = NAN;  // a second; NaN: not known
  float metres = NAN;  // a second; NaN: not known, or the zones have no ground
};

// An area in which an object of the frame is.
struct Presence {
  uint32_t zone = 0;
  float dwell = NAN;  // seconds since it entered; NaN: it has no track
};

enum class EventKind { Enter, Leave, Dwell, Forward, Backward };
const char* to_string(EventKind kind) noexcept;

struct Event {
  EventKind kind = EventKind::Enter;
  uint32_t zone = 0, track = 0, group = 0;
  int32_t class_index = kNoClass;
  float dwell = NAN;  // Leave and Dwell: seconds since it entered
  Speed speed{};
};

// Counts of one zone, for one class or in total: entered = left + followed_inside.
struct Counts {
  uint64_t followed_inside = 0, entered = 0, left = 0;  // of areas
  uint64_t without_track = 0;          // objects of the frame that are inside and have no track
  uint64_t forward = 0, backward = 0;  // of lines
  // Sums over the objects of the frame that are inside and whose speed is known.
  double pixels_sum = 0, metres_sum = 0;
  uint32_t pixels_known = 0, metres_known = 0;

  uint64_t inside() const noexcept { return followed_inside + without_track; }
  Speed mean_speed() const noexcept;
};
struct ZoneCounts {
  Counts total;
  std::map<int32_t, Counts> of_class;  // without kNoClass
};

struct CounterSettings {
  // Nanoseconds that a track may be missing; after that it has left, and its number is a new track.
  int64_t max_gap = 1000000000;
  int64_t speed_window = 1000000000;  // nanoseconds back from now over which a speed is a mean
};

class ZoneCounter {
 public:
  ZoneCounter() = default;
  explicit ZoneCounter(CounterSettings settings) : settings_(settings) {}

  // Replaces the zones between two frames. Zones of the same name and kind keep their counts, and
  // areas their stays; what has another name is new.
  void set_zones(std::shared_ptr<const ZoneSet> zones);
  const std::shared_ptr<const ZoneSet>& zones() const noexcept { return zones_; }

  // The size of the source picture: points of boxes that extend beyond it count at its edge, except
  // for lines on the edge. 0 x 0, before the first call too: not known.
  void set_picture(Size picture) noexcept { picture_ = picture; }
  // A frame; `time` in nanoseconds. A time that is equal to the last one or kNoTime adds nothing
  // to dwell times and speeds; one before the last one ends all stays first.
  void update(int64_t time, std::span<const Sighting> sightings);
  // Whether update() would end all stays.
  bool is_backward(int64_t time) const noexcept {
    return time != kNoTime && now_ != kNoTime && time < now_;
  }
  // Ends all stays; counts continue. The events are those of the stays.
  void forget_tracks();
  // Forgets counts too.
  void reset();

  // Returns the speeds of the last update, one for each sighting.
  const std::vector<Speed>& speeds() const noexcept { return speeds_; }
  std::span<const Presence> get_presences(size_t sighting) const noexcept;
  const std::vector<Event>& events() const noexcept { return events_; }
  // One for each zone.
  const std::vector<ZoneCounts>& counts() const noexcept { return counts_; }
  size_t tracks() const noexcept { return tracks_.size(); }
  // What the limits left out since reset(): tracks, stays or events.
  uint64_t left_out() const noexcept { return left_out_; }
  uint64_t times_backward() const noexcept { return times_backward_; }

 private:
  struct Stay {
    uint32_t zone = 0;
    int32_t class_index = kNoClass;
    int64_t since = 0;
    bool is_reported = false;  // the Dwell event was
  };
  // A line that the track has crossed and from which it is not yet farther than the margin.
  struct NearLine {
    uint32_t zone = 0;
    int crossed = 0;  // forward less backward since the crossing that was counted
  };
  struct Sample {
    int64_t time = 0;
    Point pixel;
  };
  using ReferencePoints = std::array<Point, kReferences>;
  struct Track {
    uint64_t frame = 0;               // of the last sighting
    int64_t time = 0;                 // likewise
    ReferencePoints at{}, seen_at{};  // in the picture, and as the box has them
    std::vector<Stay> stays{};        // in the order of their zones
    std::vector<NearLine> near_lines{};
    std::array<Sample, kSampleLimit> samples{};
    size_t n_samples = 0, oldest = 0;  // of `samples`, a ring
  };
  struct Bounds {
    double left = 0, top = 0, right = 0, bottom = 0;
  };

  static bool is_before(const Stay& stay, uint32_t zone) noexcept { return stay.zone < zone; }
  static bool is_staying(const Track& track, uint32_t zone) noexcept;
  Point find_point(const Sighting& sighting, Reference reference) const noexcept;
  void begin_frame();
  void clear_frame_counts();
  void forget_old_tracks();
  void end_track(uint64_t key, Track* track);
  void see(const Sighting& sighting);
  void see_without_track(const Sighting& sighting);
  Track* find_track(const Sighting& sighting, bool* is_new);
  void update_area(uint32_t zone, const Sighting& sighting, Track* track);
  void update_line(uint32_t zone, Point from, Point to, const Sighting& sighting, Track* track);
  void count_crossing(uint32_t zone, bool is_forward, const Sighting& sighting);
  void update_stay(uint32_t zone, bool is_inside, const Sighting& sighting, Track* track);
  Speed compute_speed(Track* track, Point pixel) const;
  void add_event(const Event& event);
  template <class Change>
  void count(uint32_t zone, int32_t class_index, const Change& change);
  void add_speed(uint32_t zone, int32_t class_index, const Speed& speed);

  CounterSettings settings_;
  Size picture_{};
  std::shared_ptr<const ZoneSet> zones_ = std::make_shared<const ZoneSet>();
  std::vector<Bounds> bounds_;  // of each zone
  std::vector<ZoneCounts> counts_;
  std::vector<Counts*> of_frame_;  // with numbers of the last frame; some twice
  size_t classes_ = 0;             // entries of all counts_
  std::unordered_map<uint64_t, Track> tracks_;
  int64_t now_ = kNoTime;
  uint64_t frame_ = 0;
  uint64_t left_out_ = 0, times_backward_ = 0;

  std::vector<Speed> speeds_;
  std::vector<Presence> presences_;
  std::vector<size_t> first_presence_;  // of each sighting
  std::vector<Event> events_;
  Speed speed_;  // of the sighting that is being seen
};

}  // namespace weir::zone
