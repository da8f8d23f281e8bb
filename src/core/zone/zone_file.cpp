// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/zone/zone_file.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <system_error>
#include <unordered_map>

#include "core/text/json_depth.hpp"
#include "core/text/text.hpp"
#include "weir/join.hpp"
#include "weir/label_file.hpp"

namespace weir::zone {
namespace {

using Json = nlohmann::json;

constexpr size_t kBytesLimit = size_t{16} << 20;
constexpr int kDepthLimit = 8;
constexpr size_t kFaultLimit = 20;      // that are listed
constexpr size_t kNameLimit = 256;      // bytes
constexpr double kFarthest = 1e6;       // pixels
constexpr double kMaxDwell = 1e6;       // seconds
constexpr double kCoarsestScale = 1e6;  // metres per pixel
constexpr double kWidestMargin = 10;    // longer sides of a box

// Collects the faults of a file.
class Faults {
 public:
  void add(const std::string& path, const Json* value, const std::string& needed) {
    if (++count_ > kFaultLimit) return;
    std::string shown =
        value ? value->dump(-1, ' ', false, Json::error_handler_t::replace) : "missing";
    if (shown.size() > 60) shown = shown.substr(0, 60) + "...";
    list_.push_back(path + " is " + shown + ", needs " + needed);
  }
  bool empty() const noexcept { return count_ == 0; }
  std::string text() const {
    const std::string more =
        count_ > kFaultLimit ? "; and " + std::to_string(count_ - kFaultLimit) + " more" : "";
    return join(list_, "; ") + more;
  }

 private:
  size_t count_ = 0;
  std::vector<std::string> list_;
};

std::optional<double> finite(const Json& value) {
  if (!value.is_number()) return std::nullopt;
  const auto number = value.get<double>();
  return std::isfinite(number) ? std::optional(number) : std::nullopt;
}

class Parser {
 public:
  explicit Parser(Faults* faults) : faults_(*faults) {}

  ZoneSet parse(const Json& root) {
    ZoneSet out;
    if (!root.is_object()) {
      faults_.add("the file", &root, "an object {\"version\": 1, \"zones\": [...]}");
      return out;
    }
    only(root, "", {"version", "zones", "ground", "$schema", "comment"});
    const Json* version = member(root, "version");
    if (!version || *version != 1) faults_.add("version", version, "1");
    const Json* zones = member(root, "zones");
    if (!zones || !zones->is_array() || zones->size() > kZoneLimit)
      faults_.add("zones", zones, "a list of at most " + std::to_string(kZoneLimit) + " zones");
    else
      for (size_t i = 0; i < zones->size(); ++i)
        out.zones.push_back(zone((*zones)[i], "zones[" + std::to_string(i) + "]"));
    if (const Json* ground = member(root, "ground")) out.ground = this->ground(*ground);
    return out;
  }

 private:
  static const Json* member(const Json& object, const char* name) {
    const auto at = object.find(name);
    return at == object.end() ? nullptr : &*at;
  }
  void only(const Json& object, const std::string& path, std::vector<std::string> known) {
    for (const auto& [key, value] : object.items()) {
      if (std::find(known.begin(), known.end(), key) != known.end()) continue;
      const std::string close = nearest(key, known);
      faults_.add(path.empty() ? key : path + "." + key, &value,
                  close.empty() ? "to be removed: no such member is known"
                                : "another name: did you mean " + close + "?");
    }
  }

  std::optional<Point> point(const Json& value) {
    if (!value.is_array() || value.size() != 2) return std::nullopt;
    const auto x = finite(value[0]), y = finite(value[1]);
    if (!x || !y || std::abs(*x) > kFarthest || std::abs(*y) > kFarthest) return std::nullopt;
    return Point{*x, *y};
  }
  // The points of a list of `min` to `max` entries [x, y]; none if it has faults.
  std::vector<Point> points(const Json* list, const std::string& path, size_t min, size_t max) {
    std::vector<Point> out;
    if (!list || !list->is_array() || list->size() < min || list->size() > max) {
      const std::string count =
          min == max ? std::to_string(min) : std::to_string(min) + " to " + std::to_string(max);
      faults_.add(path, list, count + " points [x, y]");
      return out;
    }
    for (size_t i = 0; i < list->size(); ++i) {
      const auto found = point((*list)[i]);
      if (!found)
        faults_.add(path + "[" + std::to_string(i) + "]", &(*list)[i],
                    "two finite numbers [x, y] within 1000000");
      out.push_back(found.value_or(Point{}));
    }
    return out;
  }

  Zone zone(const Json& json, const std::string& path) {
    Zone out;
    if (!json.is_object()) {
      faults_.add(path, &json, "an object {\"name\": ..., \"polygon\": [...]}");
      return out;
    }
    only(json, path, {"name", "polygon", "line", "reference", "dwell", "margin", "comment"});
    name(member(json, "name"), path + ".name", &out);
    const Json *polygon = member(json, "polygon"), *line = member(json, "line");
    if (!polygon == !line) {
      faults_.add(path, &json, "either \"polygon\" or \"line\"");
    } else if (polygon) {
      out.points = points(polygon, path + ".polygon", 3, kPointLimit);
    } else {
      out.kind = Kind::Line;
      out.points = points(line, path + ".line", 2, 2);
      if (out.points.size() == 2 && out.points[0].x == out.points[1].x &&
          out.points[0].y == out.points[1].y)
        faults_.add(path + ".line", line, "two different points");
    }
    reference(member(json, "reference"), path + ".reference", &out);
    if (const Json* dwell = member(json, "dwell")) {
      const auto seconds = finite(*dwell);
      if (!seconds || *seconds <= 0 || *seconds > kMaxDwell)
        faults_.add(path + ".dwell", dwell, "seconds above 0 and at most 1000000");
      else if (out.kind == Kind::Line)
        faults_.add(path + ".dwell", dwell, "a polygon: nothing dwells on a line");
      else
        out.dwell = *seconds;
    }
    margin(member(json, "margin"), path + ".margin", &out);
    return out;
  }

  void name(const Json* value, const std::string& path, Zone* out) {
    const bool is_name = value && value->is_string() &&
                         !value->get_ref<const std::string&>().empty() &&
                         value->get_ref<const std::string&>().size() <= kNameLimit &&
                         is_text(value->get_ref<const std::string&>());
    if (!is_name)
      return faults_.add(path, value, "a string of 1 to " + std::to_string(kNameLimit) + " bytes");
    out->name = value->get<std::string>();
    const auto [known, is_new] = paths_.emplace(out->name, path);
    if (!is_new) faults_.add(path, value, "a unique name: " + known->second + " has the same one");
  }

  void reference(const Json* value, const std::string& path, Zone* out) {
    if (!value) return;
    static constexpr std::pair<const char*, Reference> kNames[] = {
        {"bottom", Reference::Bottom}, {"centre", Reference::Centre}, {"top", Reference::Top}};
    for (const auto& [text, reference] : kNames)
      if (value->is_string() && *value == text) {
        out->reference = reference;
        return;
      }
    faults_.add(path, value, "bottom, centre or top");
  }

  void margin(const Json* value, const std::string& path, Zone* out) {
    if (!value) {
      if (out->kind == Kind::Line) out->margin = kLineMargin;
      return;
    }
    const auto part = finite(*value);
    if (!part || *part < 0 || *part > kWidestMargin)
      return faults_.add(path, value, "a part of the longer side of a box, 0 to 10");
    out->margin = *part;
  }

  std::optional<Ground> ground(const Json& json) {
    if (!json.is_object()) {
      faults_.add("ground", &json, "an object with metres_per_pixel, or picture and metres");
      return std::nullopt;
    }
    only(json, "ground", {"metres_per_pixel", "picture", "metres", "comment"});
    const Json* scale = member(json, "metres_per_pixel");
    const Json *picture = member(json, "picture"), *metres = member(json, "metres");
    if (scale && !picture && !metres) {
      const auto number = finite(*scale);
      if (number && *number > 0 && *number <= kCoarsestScale) return Ground(*number);
      faults_.add("ground.metres_per_pixel", scale, "a number above 0 and at most 1000000");
      return std::nullopt;
    }
    if (scale) {
      faults_.add("ground", &json, "either metres_per_pixel, or picture and metres");
      return std::nullopt;
    }
    const auto from = points(picture, "ground.picture", 4, 4);
    const auto to = points(metres, "ground.metres", 4, 4);
    if (from.size() != 4 || to.size() != 4) return std::nullopt;
    std::array<Point, 4> four{}, ground{};
    std::copy(from.begin(), from.end(), four.begin());
    std::copy(to.begin(), to.end(), ground.begin());
    const auto out = Ground::from_points(four, ground);
    if (!out)
      faults_.add("ground", &json,
                  "four corners in the same order; no three of them may lie on a line");
    return out;
  }

  Faults& faults_;
  std::unordered_map<std::string, std::string> paths_;  // of each name
};

Error not_readable(const std::string& path, const std::string& reason) {
  return Error{.code = Code::FILE_NOT_FOUND,
               .what = "the zones file cannot be read",
               .offered = path + ": " + reason,
               .needed = "a JSON file as docs/zones.md defines it",
               .fix = "zones=/path/to/zones.json"};
}

Error invalid(const std::string& place, std::string faults) {
  return Error{
      .code = Code::OPTION_VALUE,
      .what = "the zones file cannot be used",
      .offered = place,
      .needed = "a JSON file as docs/zones.md defines it",
      .difference = std::move(faults),
      .fix = R"({"version": 1, "zones": [{"name": "door", "line": [[100, 400], [500, 400]]}]})"};
}

}  // namespace

bool Zone::operator==(const Zone& other) const {
  const auto equal = [](const Point& a, const Point& b) { return a.x == b.x && a.y == b.y; };
  return name == other.name && kind == other.kind && reference == other.reference &&
         dwell == other.dwell && margin == other.margin &&
         std::equal(points.begin(), points.end(), other.points.begin(), other.points.end(), equal);
}

Result<ZoneSet> parse_zones(std::string_view text, const std::string& place) {
  if (text.size() > kBytesLimit) return invalid(place, "it has more than 16 MiB");
  if (json_depth(text) > kDepthLimit)
    return invalid(place, "its lists and objects are nested too deeply");
  Json root;
  try {
    root = Json::parse(text);
  } catch (const Json::exception& fault) {
    return invalid(place, std::string("it is not JSON: ") + fault.what());
  }
  Faults faults;
  ZoneSet out = Parser(&faults).parse(root);
  if (!faults.empty()) return invalid(place, faults.text());
  out.text = text;
  return out;
}

Result<ZoneSet> read_zones(const std::string& path) {
  std::error_code reason;
  const auto type = std::filesystem::status(path, reason).type();
  if (type == std::filesystem::file_type::directory) return not_readable(path, "it is a folder");
  // Opening a FIFO would wait for its writer.
  if (type != std::filesystem::file_type::regular && std::filesystem::exists(path, reason))
    return not_readable(path, "it is not a regular file");
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file) return not_readable(path, std::error_code(errno, std::generic_category()).message());
  std::string text;
  text.resize(kBytesLimit + 1);
  file.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<size_t>(file.gcount()));
  return parse_zones(text, path);
}

FileState state_of_file(const std::string& path) noexcept {
  struct stat found {};
  if (stat(path.c_str(), &found) != 0) return {};
  return {found.st_mtim.tv_sec, found.st_mtim.tv_nsec, found.st_size, found.st_ino};
}

}  // namespace weir::zone
