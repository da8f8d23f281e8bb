// Writes zones, counts and events as JSON.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/records/zone_json.hpp"

#include <cmath>

#include "core/records/record_text.hpp"
#include "core/zone/zone_counter.hpp"

namespace weir::records {
namespace {

// Appends `,"name":number` if it is known. Counts are whole numbers.
void append_member(const char* name, float number, std::string* out) {
  if (!std::isfinite(number)) return;
  *out += std::string(",\"") + name + "\":";
  append_number(number, out);
}
void append_count(const char* name, float number, std::string* out) {
  if (!(number >= 0 && number < 1e15f)) return;
  *out += std::string(",\"") + name + "\":";
  append_number(static_cast<int64_t>(number), out);
}

// The name of a zone, or its number from 1 on.
void append_zone(const WriterSettings& settings, uint32_t zone, std::string* out) {
  append_json_string(zone < settings.zones.size() ? settings.zones[zone] : std::to_string(zone + 1),
                     out);
}

// Class numbers of several sources are taken for the same classes: those of the first one.
void append_class(const WriterSettings& settings, int32_t class_index, std::string* out) {
  std::string number;
  *out += "\"index\":";
  append_number(int64_t{class_index}, out);
  *out += ",\"label\":";
  append_json_string(settings.labels.of(0, class_index, &number), out);
}

void append_counts(const ZoneCount& counts, std::string* out) {
  append_count("inside", counts.inside, out);
  append_count("entered", counts.entered, out);
  append_count("left", counts.left, out);
  append_count("forward", counts.forward, out);
  append_count("backward", counts.backward, out);
  append_member("speed", counts.speed, out);
  append_member("ground_speed", counts.ground_speed, out);
}

// The total of a zone is followed by its classes.
void append_zones(const WriterSettings& settings, const ResultFrame& frame, std::string* out) {
  *out += ",\"zones\":[";
  const auto& all = frame.zone_counts;
  for (size_t i = 0; i < all.size();) {
    if (i > 0) *out += ',';
    *out += "{\"name\":";
    append_zone(settings, all[i].zone, out);
    const size_t first = i;
    if (all[i].class_index < 0) append_counts(all[i++], out);
    *out += ",\"classes\":[";
    for (char before = 0;
         i < all.size() && all[i].zone == all[first].zone && all[i].class_index >= 0; ++i) {
      if (before) *out += before;
      before = ',';
      *out += '{';
      append_class(settings, all[i].class_index, out);
      append_counts(all[i], out);
      *out += '}';
    }
    *out += "]}";
  }
  *out += ']';
}

void append_events(const WriterSettings& settings, const ResultFrame& frame, std::string* out) {
  *out += ",\"events\":[";
  for (size_t i = 0; i < frame.zone_events.size(); ++i) {
    const ZoneEvent& event = frame.zone_events[i];
    *out += i > 0 ? ",{\"event\":\"" : "{\"event\":\"";
    *out += zone::name_of(static_cast<zone::EventKind>(event.kind));
    *out += "\",\"zone\":";
    append_zone(settings, event.zone, out);
    append_count("track", static_cast<float>(event.track), out);
    if (event.class_index >= 0) {
      *out += ',';
      append_class(settings, event.class_index, out);
    }
    append_member("dwell", event.dwell, out);
    append_member("speed", event.speed, out);
    append_member("ground_speed", event.ground_speed, out);
    *out += '}';
  }
  *out += ']';
}

}  // namespace

void append_zones_of(const WriterSettings& settings, const ResultFrame& frame,
                     const ResultObject& object, std::string* out) {
  append_member("speed", object.speed, out);
  append_member("ground_speed", object.ground_speed, out);
  if (object.n_zones == 0) return;
  *out += ",\"zones\":[";
  for (uint32_t i = 0; i < object.n_zones; ++i) {
    const ObjectZone& zone = frame.zones[object.first_zone + i];
    *out += i > 0 ? ",{\"name\":" : "{\"name\":";
    append_zone(settings, zone.zone, out);
    append_member("dwell", zone.dwell, out);
    *out += '}';
  }
  *out += ']';
}

void append_zones_and_events(const WriterSettings& settings, const ResultFrame& frame,
                             std::string* out) {
  append_zones(settings, frame, out);
  append_events(settings, frame, out);
}

}  // namespace weir::records
