// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/records/zone_columns.hpp"

#include <algorithm>
#include <cmath>

#include "core/text/text.hpp"

namespace weir::records {
namespace {

constexpr size_t kCountLength = 10, kEventLength = 8;

void append_counts(float number, float class_index, zone::Kind kind, const zone::Counts& counts,
                   std::vector<float>* out) {
  const bool is_area = kind == zone::Kind::Area;
  const auto of_area = [&](uint64_t n) { return is_area ? static_cast<float>(n) : NAN; };
  const auto of_line = [&](uint64_t n) { return is_area ? NAN : static_cast<float>(n); };
  const zone::Speed speed = counts.mean_speed();
  out->insert(out->end(), {0, number, class_index, of_area(counts.inside()),
                           of_area(counts.entered), of_area(counts.left), of_line(counts.forward),
                           of_line(counts.backward), speed.pixels, speed.metres});
}

}  // namespace

std::string with_zone_columns(const std::string& columns, uint32_t zones_per_object) {
  const std::string count = std::to_string(zones_per_object);
  return columns + ",speed,ground-speed,zone:" + count + ",dwell:" + count;
}

ColumnPlace find_column(std::string_view columns, std::string_view name) {
  uint64_t next = 0;
  for (const std::string_view entry : split(columns, ",")) {
    const size_t colon = entry.find(':');
    const std::string_view entry_name = entry.substr(0, colon);
    uint64_t count = 1;
    if (colon != std::string_view::npos)
      count = parse_unsigned(entry.substr(colon + 1)).value_or(0);
    if (entry_name == name) return {static_cast<int32_t>(next), static_cast<uint32_t>(count)};
    if (colon != std::string_view::npos && entry_name == "xy") count *= 2;
    if (colon != std::string_view::npos && entry_name == "xys") count *= 3;
    next += count;
  }
  return {};
}

ZoneColumns zone_columns(std::string_view columns) {
  ZoneColumns out{find_column(columns, "speed"), find_column(columns, "ground-speed"),
                  find_column(columns, "zone"), find_column(columns, "dwell")};
  if (out.zone.count != out.dwell.count) out = {};
  return out;
}

void append_count_rows(const zone::ZoneCounter& counter, std::vector<float>* out) {
  const auto& zones = counter.zones()->zones;
  if (zones.empty()) out->resize(out->size() + kCountLength);
  for (size_t i = 0; i < zones.size(); ++i) {
    const auto number = static_cast<float>(i + 1);
    const zone::ZoneCounts& counts = counter.counts()[i];
    append_counts(number, zone::kNoClass, zones[i].kind, counts.total, out);
    for (const auto& [index, of_class] : counts.of_class)
      append_counts(number, static_cast<float>(index), zones[i].kind, of_class, out);
  }
}

void append_event_rows(const zone::ZoneCounter& counter, std::vector<float>* out) {
  if (counter.events().empty()) out->resize(out->size() + kEventLength);
  for (const zone::Event& event : counter.events())
    out->insert(out->end(),
                {0, static_cast<float>(event.zone + 1), static_cast<float>(event.kind) + 1,
                 static_cast<float>(event.class_index), static_cast<float>(event.track),
                 event.dwell, event.speed.pixels, event.speed.metres});
}

size_t write_zone_columns(const zone::ZoneCounter& counter, size_t sighting, std::span<float> out) {
  const size_t room = (out.size() - 2) / 2;
  std::fill(out.begin(), out.end(), 0.0f);
  out[0] = counter.speeds()[sighting].pixels;
  out[1] = counter.speeds()[sighting].metres;
  const auto presences = counter.get_presences(sighting);
  const size_t written = std::min(room, presences.size());
  for (size_t i = 0; i < written; ++i) {
    out[2 + i] = static_cast<float>(presences[i].zone + 1);
    out[2 + room + i] = presences[i].dwell;
  }
  return presences.size() - written;
}

}  // namespace weir::records
