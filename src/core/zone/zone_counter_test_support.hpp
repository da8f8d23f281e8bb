// Zones, objects and frames for tests of ZoneCounter.
// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "core/zone/zone_counter.hpp"

namespace weir::zone {

inline constexpr int64_t kSecond = 1000000000;

inline Zone area(const std::string& name, double left, double top, double right, double bottom,
                 double dwell = 0) {
  return {.name = name,
          .points = {{left, top}, {right, top}, {right, bottom}, {left, bottom}},
          .dwell = dwell};
}
inline Zone line(const std::string& name, Point a, Point b) {
  return {.name = name, .kind = Kind::Line, .points = {a, b}};
}
inline std::shared_ptr<const ZoneSet> set_of(std::vector<Zone> zones) {
  return std::make_shared<const ZoneSet>(ZoneSet{std::move(zones), {}, {}});
}
// An object whose bottom centre is at x, y.
inline Sighting at(double x, double y, uint32_t track, int32_t class_index = 0) {
  const auto fx = static_cast<float>(x), fy = static_cast<float>(y);
  return {.track = track, .class_index = class_index, .box = {fx - 5, fy - 20, fx + 5, fy}};
}
using Sightings = std::vector<Sighting>;

// "enter door 7" for each event.
inline std::vector<std::string> texts_of(const ZoneCounter& counter) {
  std::vector<std::string> out;
  for (const Event& event : counter.events())
    out.push_back(std::string(to_string(event.kind)) + " " +
                  counter.zones()->zones[event.zone].name + " " + std::to_string(event.track));
  return out;
}
using Texts = std::vector<std::string>;

class ZoneCounterTest : public testing::Test {
 protected:
  void use(std::vector<Zone> zones) { counter.set_zones(set_of(std::move(zones))); }
  Texts frame(double seconds, const Sightings& sightings) {
    counter.update(static_cast<int64_t>(seconds * 1e9 + 0.5), sightings);
    return texts_of(counter);
  }
  const Counts& total(size_t zone) const { return counter.counts()[zone].total; }
  // The number of tracked objects inside is what has entered less what has left, of every class.
  void expect_balance() const {
    for (const ZoneCounts& zone : counter.counts()) {
      EXPECT_EQ(zone.total.entered, zone.total.left + zone.total.followed_inside);
      for (const auto& [index, counts] : zone.of_class)
        EXPECT_EQ(counts.entered, counts.left + counts.followed_inside) << index;
    }
  }

  ZoneCounter counter;
};

}  // namespace weir::zone
