// Writes results with the names of members of docs/results.md.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "results_text.hpp"

#include <nlohmann/json.hpp>

namespace street {

std::string results_text(int64_t time, std::span<const Detection> people,
                         const weir::zone::ZoneCounter& counter) {
  using Json = nlohmann::ordered_json;
  Json detections = Json::array(), zones = Json::array();
  for (const Detection& person : people) {
    Json one{{"box", {person.box.x1, person.box.y1, person.box.x2, person.box.y2}},
             {"score", person.score},
             {"index", person.class_index},
             {"label", "person"}};
    if (person.track > 0) one["track"] = person.track;
    detections.push_back(std::move(one));
  }
  const auto& known = counter.zones()->zones;
  for (size_t i = 0; i < known.size(); ++i) {
    const auto& total = counter.counts()[i].total;
    if (known[i].kind == weir::zone::Kind::Line)
      zones.push_back(
          {{"name", known[i].name}, {"forward", total.forward}, {"backward", total.backward}});
    else
      zones.push_back({{"name", known[i].name}, {"inside", total.inside()}});
  }
  const Json line{{"version", 1},
                  {"time", static_cast<double>(time) / 1e9},
                  {"detections", std::move(detections)},
                  {"zones", std::move(zones)}};
  return line.dump() + '\n';
}

}  // namespace street
