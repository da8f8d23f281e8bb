// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/zone/zone_counter.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace weir::zone {
namespace {

constexpr double kNanoseconds = 1e9;  // of a second
constexpr uint32_t kGone = UINT32_MAX;

uint64_t make_key(const Sighting& sighting) noexcept {
  return uint64_t{sighting.group} << 32 | sighting.track;
}

float seconds_between(int64_t from, int64_t to) noexcept {
  return static_cast<float>(static_cast<double>(to - from) / kNanoseconds);
}

double distance(Point a, Point b) noexcept {
  return std::hypot(a.x - b.x, a.y - b.y);
}

void enter(Counts* counts) noexcept {
  ++counts->entered, ++counts->followed_inside;
}
// The classes of a zone may have lost an entry to kClassLimit.
void leave(Counts* counts) noexcept {
  if (counts->followed_inside == 0) return;
  ++counts->left, --counts->followed_inside;
}

size_t to_index(Reference reference) noexcept {
  return static_cast<size_t>(reference);
}

// In pixels.
double get_margin(const Zone& zone, const Box& box) noexcept {
  return zone.margin * std::max(double{box.x2} - box.x1, double{box.y2} - box.y1);
}

// Entries of zones that are gone are erased; the others get their new index.
template <class Entry>
void move_to(const std::vector<uint32_t>& new_index, std::vector<Entry>* entries) {
  for (Entry& one : *entries) one.zone = new_index[one.zone];
  std::erase_if(*entries, [](const Entry& one) { return one.zone == kGone; });
}

}  // namespace

const char* to_string(EventKind kind) noexcept {
  static constexpr const char* kNames[] = {"enter", "leave", "dwell", "forward", "backward"};
  return kNames[static_cast<size_t>(kind)];
}

Speed Counts::mean_speed() const noexcept {
  Speed out;
  if (pixels_known > 0) out.pixels = static_cast<float>(pixels_sum / pixels_known);
  if (metres_known > 0) out.metres = static_cast<float>(metres_sum / metres_known);
  return out;
}

void ZoneCounter::set_zones(std::shared_ptr<const ZoneSet> zones) {
  clear_frame_counts();
  std::unordered_map<std::string, uint32_t> index_of_name;
  for (uint32_t i = 0; i < zones->zones.size(); ++i) index_of_name[zones->zones[i].name] = i;
  std::vector<ZoneCounts> counts(zones->zones.size());
  std::vector<uint32_t> new_index(counts_.size(), kGone);
  for (size_t i = 0; i < counts_.size(); ++i) {
    const Zone& old = zones_->zones[i];
    const auto found = index_of_name.find(old.name);
    if (found == index_of_name.end() || zones->zones[found->second].kind != old.kind) continue;
    new_index[i] = found->second;
    counts[found->second] = std::move(counts_[i]);
  }
  for (auto& [key, track] : tracks_) {
    move_to(new_index, &track.stays);
    move_to(new_index, &track.near_lines);
    std::sort(track.stays.begin(), track.stays.end(),
              [](const Stay& a, const Stay& b) { return a.zone < b.zone; });
  }
  zones_ = std::move(zones);
  counts_ = std::move(counts);
  classes_ = 0;
  for (const ZoneCounts& one : counts_) classes_ += one.of_class.size();
  bounds_.clear();
  for (const Zone& zone : zones_->zones) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    Bounds around{kInfinity, kInfinity, -kInfinity, -kInfinity};
    for (const Point& p : zone.points) {
      around.left = std::min(around.left, p.x), around.right = std::max(around.right, p.x);
      around.top = std::min(around.top, p.y), around.bottom = std::max(around.bottom, p.y);
    }
    bounds_.push_back(around);
  }
}

void ZoneCounter::clear_frame_counts() {
  for (Counts* counts : of_frame_) {
    counts->pixels_sum = counts->metres_sum = 0;
    counts->pixels_known = counts->metres_known = 0;
    counts->without_track = 0;
  }
  of_frame_.clear();
}

void ZoneCounter::begin_frame() {
  ++frame_;
  speeds_.clear();
  presences_.clear();
  first_presence_.clear();
  events_.clear();
  clear_frame_counts();
}

void ZoneCounter::update(int64_t time, std::span<const Sighting> sightings) {
  begin_frame();
  if (is_backward(time)) {
    ++times_backward_;
    forget_tracks();
  }
  if (time != kNoTime) now_ = time;
  if (now_ == kNoTime) now_ = 0;
  forget_old_tracks();
  for (const Sighting& sighting : sightings) {
    first_presence_.push_back(presences_.size());
    see(sighting);
    speeds_.push_back(speed_);
  }
}

std::span<const Presence> ZoneCounter::get_presences(size_t sighting) const noexcept {
  const size_t first = first_presence_[sighting];
  const size_t end =
      sighting + 1 < first_presence_.size() ? first_presence_[sighting + 1] : presences_.size();
  return std::span(presences_).subspan(first, end - first);
}

void ZoneCounter::forget_old_tracks() {
  for (auto at = tracks_.begin(); at != tracks_.end();) {
    if (now_ - at->second.time <= settings_.max_gap) {
      ++at;
      continue;
    }
    end_track(at->first, &at->second);
    at = tracks_.erase(at);
  }
}

void ZoneCounter::forget_tracks() {
  events_.clear();
  for (auto& [key, track] : tracks_) end_track(key, &track);
  tracks_.clear();
  now_ = kNoTime;
}

void ZoneCounter::reset() {
  const auto zones = zones_;
  const Size picture = picture_;
  *this = ZoneCounter(settings_);
  picture_ = picture;
  set_zones(zones);
}

void ZoneCounter::end_track(uint64_t key, Track* track) {
  for (const Stay& stay : track->stays) {
    count(stay.zone, stay.class_index, leave);
    add_event({.kind = EventKind::Leave,
               .zone = stay.zone,
               .track = static_cast<uint32_t>(key),
               .group = static_cast<uint32_t>(key >> 32),
               .class_index = stay.class_index,
               .dwell = seconds_between(stay.since, track->time)});
  }
  track->stays.clear();
}

// Null: the object is not followed.
ZoneCounter::Track* ZoneCounter::find_track(const Sighting& sighting, bool* is_new) {
  if (sighting.track == 0) return nullptr;
  const uint64_t key = make_key(sighting);
  const auto known = tracks_.find(key);
  *is_new = known == tracks_.end();
  if (!*is_new) return known->second.frame == frame_ ? nullptr : &known->second;
  if (tracks_.size() < kTrackLimit) return &tracks_[key];
  ++left_out_;
  return nullptr;
}

Point ZoneCounter::find_point(const Sighting& sighting, Reference reference) const noexcept {
  const Point at = reference_point(sighting.box, sighting.rotation, reference);
  return picture_.width > 0 && picture_.height > 0 ? move_into(picture_, sighting.box, at) : at;
}

void ZoneCounter::see(const Sighting& sighting) {
  speed_ = {};
  bool is_new = false;
  Track* track = find_track(sighting, &is_new);
  if (!track) return see_without_track(sighting);
  const ReferencePoints from = track->at, seen_from = track->seen_at;
  for (size_t i = 0; i < kReferences; ++i) {
    const auto reference = static_cast<Reference>(i);
    track->at[i] = find_point(sighting, reference);
    track->seen_at[i] = reference_point(sighting.box, sighting.rotation, reference);
  }
  track->frame = frame_;
  track->time = now_;
  speed_ =
      compute_speed(track, reference_point(sighting.box, sighting.rotation, Reference::Bottom));
  for (uint32_t i = 0; i < bounds_.size(); ++i) {
    const Zone& zone = zones_->zones[i];
    const size_t reference = to_index(zone.reference);
    if (zone.kind == Kind::Area)
      update_area(i, sighting, track);
    else if (!is_new && is_on_edge(picture_, zone.points[0], zone.points[1]))
      update_line(i, seen_from[reference], track->seen_at[reference], sighting, track);
    else if (!is_new)
      update_line(i, from[reference], track->at[reference], sighting, track);
  }
}

void ZoneCounter::update_area(uint32_t zone, const Sighting& sighting, Track* track) {
  const Zone& area = zones_->zones[zone];
  const Bounds& around = bounds_[zone];
  const Point at = track->at[to_index(area.reference)];
  bool is_inside = at.x >= around.left && at.x <= around.right && at.y >= around.top &&
                   at.y <= around.bottom && contains(area.points, at);
  if (!is_inside && track->stays.empty()) return;
  if (!is_inside && area.margin > 0 && is_staying(*track, zone))
    is_inside = distance_to_outline(area.points, at) <= get_margin(area, sighting.box);
  update_stay(zone, is_inside, sighting, track);
}

// The first crossing counts at once. While the object stays near the line, further ones only change
// `crossed`, and what they come to counts when the object is farther than the margin.
void ZoneCounter::update_line(uint32_t zone, Point from, Point to, const Sighting& sighting,
                              Track* track) {
  const Zone& line = zones_->zones[zone];
  const Point a = line.points[0], b = line.points[1];
  const Crossing crossed = crossing(a, b, from, to);
  auto& lines = track->near_lines;
  const auto near = std::find_if(lines.begin(), lines.end(),
                                 [zone](const NearLine& one) { return one.zone == zone; });
  if (crossed == Crossing::None && near == lines.end()) return;
  const bool is_near = distance_to_line(a, b, to) <= get_margin(line, sighting.box);
  if (near == lines.end()) {
    count_crossing(zone, crossed == Crossing::Forward, sighting);
    if (is_near && line.margin > 0 && lines.size() < kStayLimit) lines.push_back({.zone = zone});
    return;
  }
  if (crossed != Crossing::None) near->crossed += crossed == Crossing::Forward ? 1 : -1;
  if (is_near) return;
  if (near->crossed != 0) count_crossing(zone, near->crossed > 0, sighting);
  lines.erase(near);
}

void ZoneCounter::count_crossing(uint32_t zone, bool is_forward, const Sighting& sighting) {
  count(zone, sighting.class_index,
        [&](Counts* counts) { ++(is_forward ? counts->forward : counts->backward); });
  add_event({.kind = is_forward ? EventKind::Forward : EventKind::Backward,
             .zone = zone,
             .track = sighting.track,
             .group = sighting.group,
             .class_index = sighting.class_index,
             .speed = speed_});
}

// Counts it as inside for this frame.
void ZoneCounter::see_without_track(const Sighting& sighting) {
  for (uint32_t i = 0; i < bounds_.size(); ++i) {
    const Zone& zone = zones_->zones[i];
    const Point at = find_point(sighting, zone.reference);
    if (zone.kind != Kind::Area || !contains(zone.points, at)) continue;
    count(i, sighting.class_index, [this](Counts* counts) {
      ++counts->without_track;
      of_frame_.push_back(counts);
    });
    presences_.push_back({.zone = i});
  }
}

bool ZoneCounter::is_staying(const Track& track, uint32_t zone) noexcept {
  const auto at = std::lower_bound(track.stays.begin(), track.stays.end(), zone, is_before);
  return at != track.stays.end() && at->zone == zone;
}

void ZoneCounter::update_stay(uint32_t zone, bool is_inside, const Sighting& sighting,
                              Track* track) {
  auto& stays = track->stays;
  auto stay = std::lower_bound(stays.begin(), stays.end(), zone, is_before);
  const bool was_inside = stay != stays.end() && stay->zone == zone;
  Event event{.zone = zone, .track = sighting.track, .group = sighting.group, .speed = speed_};
  if (!is_inside) {
    if (!was_inside) return;
    event.kind = EventKind::Leave;
    event.class_index = stay->class_index;
    event.dwell = seconds_between(stay->since, now_);
    count(zone, stay->class_index, leave);
    stays.erase(stay);
    return add_event(event);
  }
  if (!was_inside) {
    if (stays.size() == kStayLimit) {
      ++left_out_;
      return;
    }
    stay = stays.insert(stay, {.zone = zone, .class_index = sighting.class_index, .since = now_});
    event.class_index = stay->class_index;
    count(zone, stay->class_index, enter);
    add_event(event);
  }
  const float dwell = seconds_between(stay->since, now_);
  presences_.push_back({zone, dwell});
  add_speed(zone, stay->class_index, speed_);
  const double threshold = zones_->zones[zone].dwell;
  if (threshold <= 0 || stay->is_reported ||
      static_cast<double>(now_ - stay->since) < threshold * kNanoseconds)
    return;
  stay->is_reported = true;
  event.kind = EventKind::Dwell;
  event.class_index = stay->class_index;
  event.dwell = dwell;
  add_event(event);
}

// The mean over the positions within the window; the newest is `pixel`.
Speed ZoneCounter::compute_speed(Track* track, Point pixel) const {
  const auto sample = [track](size_t i) -> Sample& {
    return track->samples[(track->oldest + i) % kSampleLimit];
  };
  const bool is_same_time = track->n_samples > 0 && sample(track->n_samples - 1).time == now_;
  if (!is_same_time && track->n_samples == kSampleLimit) ++track->oldest, --track->n_samples;
  if (!is_same_time) ++track->n_samples;
  sample(track->n_samples - 1) = {now_, pixel};
  while (track->n_samples > 1 && now_ - sample(0).time > settings_.speed_window)
    ++track->oldest, --track->n_samples;
  track->oldest %= kSampleLimit;
  Speed out;
  const Sample& first = sample(0);
  if (first.time == now_) return out;
  const double seconds = static_cast<double>(now_ - first.time) / kNanoseconds;
  out.pixels = static_cast<float>(distance(first.pixel, pixel) / seconds);
  if (!zones_->ground) return out;
  const auto from = zones_->ground->to_metres(first.pixel), to = zones_->ground->to_metres(pixel);
  if (from && to) out.metres = static_cast<float>(distance(*from, *to) / seconds);
  return out;
}

void ZoneCounter::add_event(const Event& event) {
  if (events_.size() < kEventLimit)
    events_.push_back(event);
  else
    ++left_out_;
}

template <class Change>
void ZoneCounter::count(uint32_t zone, int32_t class_index, const Change& change) {
  ZoneCounts& counts = counts_[zone];
  change(&counts.total);
  if (class_index == kNoClass) return;
  auto known = counts.of_class.find(class_index);
  if (known == counts.of_class.end()) {
    if (classes_ >= kClassLimit) return;
    ++classes_;
    known = counts.of_class.emplace(class_index, Counts{}).first;
  }
  change(&known->second);
}

void ZoneCounter::add_speed(uint32_t zone, int32_t class_index, const Speed& speed) {
  count(zone, class_index, [this, &speed](Counts* counts) {
    of_frame_.push_back(counts);
    if (!std::isnan(speed.pixels)) counts->pixels_sum += speed.pixels, ++counts->pixels_known;
    if (!std::isnan(speed.metres)) counts->metres_sum += speed.metres, ++counts->metres_known;
  });
}

}  // namespace weir::zone
