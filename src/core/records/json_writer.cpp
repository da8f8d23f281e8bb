// Writes results as JSON Lines: one object for each frame, by docs/schema/results-1.schema.json.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <algorithm>
#include <cmath>
#include <string>

#include "core/records/map_summary.hpp"
#include "core/records/record_text.hpp"
#include "core/records/record_writer.hpp"
#include "core/records/run_lengths.hpp"
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
    *out += zone::to_string(static_cast<zone::EventKind>(event.kind));
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

// ,"speed":..,"ground_speed":..,"zones":[{"name":..,"dwell":..}] of an object; what is not known is
// left out.
void append_object_zones(const WriterSettings& settings, const ResultFrame& frame,
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

// ,"zones":[..],"events":[..] of a frame.
void append_zones_and_events(const WriterSettings& settings, const ResultFrame& frame,
                             std::string* out) {
  append_zones(settings, frame, out);
  append_events(settings, frame, out);
}

// Writes the members of one frame.
class FrameWriter {
 public:
  FrameWriter(const WriterSettings& settings, const ResultReader& reader, const ResultFrame& frame,
              const FrameFacts& facts, std::string* out)
      : settings_(settings), reader_(reader), frame_(frame), facts_(facts), out_(*out) {
    number_detections();
  }

  void write() {
    out_ += "{\"version\":1";
    if (facts_.running_time >= 0) {
      out_ += ",\"time\":";
      append_seconds(facts_.running_time, &out_);
    }
    if (facts_.unix_time >= 0) {
      out_ += ",\"utc\":\"";
      append_utc(facts_.unix_time, &out_);
      out_ += '"';
    }
    // With several sources each entry names its own.
    if (reader_.sources().size() == 1) write_source(0);
    if (facts_.width > 0 && facts_.height > 0) {
      out_ += ",\"size\":[";
      append_number(int64_t{facts_.width}, &out_);
      out_ += ',';
      append_number(int64_t{facts_.height}, &out_);
      out_ += ']';
    }
    write_list(RowKind::Label, "labels");
    write_list(RowKind::Detection, "detections");
    write_list(RowKind::Text, "text");
    if (!frame_.class_maps.empty()) write_segments();
    if (!frame_.depths.empty()) write_depths();
    if (reader_.has_zones()) append_zones_and_events(settings_, frame_, &out_);
    out_ += "}\n";
  }

 private:
  bool is_written(const ResultObject& object) const { return object.score >= settings_.threshold; }
  // "parent" is an index in the list of detections.
  void number_detections() {
    int32_t next = 0;
    for (const ResultObject& object : frame_.objects) {
      const bool counts = get_kind(reader_, object) == RowKind::Detection && is_written(object);
      number_.push_back(counts ? next++ : -1);
    }
  }

  void write_source(uint32_t source) {
    if (reader_.sources()[source].empty()) return;
    out_ += ",\"source\":";
    append_json_string(reader_.sources()[source], &out_);
  }
  void write_numbers(std::initializer_list<float> numbers) {
    char before = '[';
    for (const float number : numbers) {
      out_ += before;
      append_number(number, &out_);
      before = ',';
    }
    out_ += ']';
  }

  // A list that the stream can have is there also when it is empty.
  void write_list(RowKind kind, const char* name) {
    bool exists = false;
    for (const RowGroup& group : reader_.groups()) exists |= group.kind() == kind;
    if (!exists) return;
    out_ += ",\"";
    out_ += name;
    out_ += "\":[";
    bool is_first = true;
    for (const ResultObject& object : frame_.objects) {
      if (get_kind(reader_, object) != kind || !is_written(object)) continue;
      if (!is_first) out_ += ',';
      is_first = false;
      write_object(kind, object);
    }
    out_ += ']';
  }

  void write_object(RowKind kind, const ResultObject& object) {
    const ResultObject* boxed = with_box(frame_, object);
    out_ += '{';
    if (kind != RowKind::Label && boxed) {
      out_ += "\"box\":";
      write_numbers({boxed->box.x1, boxed->box.y1, boxed->box.x2, boxed->box.y2});
      out_ += ',';
    }
    if (kind == RowKind::Text) {
      out_ += "\"text\":";
      append_json_string(object.text, &out_);
      out_ += ',';
    }
    out_ += "\"score\":";
    append_number(object.score, &out_);
    const uint32_t source = reader_.groups()[object.group].source;
    if (kind != RowKind::Text && object.class_index >= 0) {
      out_ += ",\"index\":";
      append_number(int64_t{object.class_index}, &out_);
      out_ += ",\"label\":";
      append_json_string(settings_.labels.of(source, object.class_index, &label_), &out_);
    }
    if (object.track > 0) {
      out_ += ",\"track\":";
      append_number(int64_t{object.track}, &out_);
    }
    if (kind != RowKind::Label && boxed && boxed->rotation != 0) {
      out_ += ",\"rotation\":";
      append_number(boxed->rotation, &out_);
    }
    const int32_t parent = object.parent >= 0 ? number_[static_cast<size_t>(object.parent)] : -1;
    if (parent >= 0) {
      out_ += ",\"parent\":";
      append_number(int64_t{parent}, &out_);
    }
    append_object_zones(settings_, frame_, object, &out_);
    write_points(object);
    write_mask(object);
    if (reader_.sources().size() > 1) write_source(source);
    out_ += '}';
  }

  // A point that was not found keeps its place as null.
  void write_points(const ResultObject& object) {
    if (object.n_points == 0) return;
    out_ += ",\"keypoints\":";
    char before = '[';
    for (uint32_t i = 0; i < object.n_points; ++i) {
      const results::KeyPoint& point = frame_.points[object.first_point + i];
      out_ += before;
      before = ',';
      if (std::isfinite(point.x) && std::isfinite(point.y) && std::isfinite(point.score))
        write_numbers({point.x, point.y, point.score});
      else
        out_ += "null";
    }
    out_ += ']';
  }

  bool has_masks() const {
    return settings_.has_masks && has_run_lengths(facts_.width, facts_.height);
  }
  void write_mask(const ResultObject& object) {
    if (!has_masks() || !object.has_box || object.mask.values.empty()) return;
    out_ += ",\"mask\":";
    append_mask(runs_of_mask(object.mask, object.box, facts_.width, facts_.height), facts_.width,
                facts_.height, &out_);
  }

  // The map from tensor `index` to the picture, if it is known.
  std::optional<SourceMap> map_to_picture(size_t tensor) const {
    const size_t index = facts_.maps.size() == 1 ? 0 : tensor;
    const bool is_known = facts_.width > 0 && index < facts_.maps.size();
    return is_known ? std::optional(facts_.maps[index]) : std::nullopt;
  }

  // Without the picture's size, the pixels of the class map are those of the picture.
  void write_segments() {
    out_ += ",\"segments\":";
    char before = '[';
    for (const ClassMapView& classes : frame_.class_maps) {
      const uint32_t width = facts_.width > 0 ? facts_.width : classes.width;
      const uint32_t height = facts_.height > 0 ? facts_.height : classes.height;
      std::vector<ClassRuns> runs;
      if (settings_.has_masks && has_run_lengths(width, height))
        runs = runs_of_classes(classes, make_map(classes, width, height), width, height);
      for (const auto& found : parts_of_classes(classes, map_to_picture(classes.tensor))) {
        out_ += before;
        before = ',';
        write_segment(classes, found);
        const auto mask = std::find_if(runs.begin(), runs.end(), [&](const ClassRuns& one) {
          return one.class_index == found.class_index;
        });
        if (mask != runs.end()) {
          out_ += ",\"mask\":";
          append_mask(mask->runs, width, height, &out_);
        }
        out_ += '}';
      }
    }
    out_ += before == '[' ? "[]" : "]";
  }
  // Without the brace at its end.
  void write_segment(const ClassMapView& classes, const ClassPart& found) {
    const auto index = static_cast<int32_t>(found.class_index);
    out_ += "{\"index\":";
    append_number(int64_t{index}, &out_);
    out_ += ",\"label\":";
    append_json_string(settings_.labels.of(classes.source, index, &label_), &out_);
    out_ += ",\"part\":";
    append_number(static_cast<float>(found.part), &out_);
    if (reader_.sources().size() > 1) write_source(classes.source);
  }
  void write_depths() {
    out_ += ",\"depth\":";
    char before = '[';
    for (const DepthView& depths : frame_.depths) {
      const DepthRange range = range_of_depths(depths, map_to_picture(depths.tensor));
      out_ += before;
      before = ',';
      out_ += "{\"least\":";
      append_number(range.min, &out_);
      out_ += ",\"greatest\":";
      append_number(range.max, &out_);
      out_ += ",\"mean\":";
      append_number(static_cast<float>(range.mean), &out_);
      if (reader_.sources().size() > 1) write_source(depths.source);
      out_ += '}';
    }
    out_ += ']';
  }
  SourceMap make_map(const ClassMapView& classes, uint32_t width, uint32_t height) const {
    if (const auto known = map_to_picture(classes.tensor)) return *known;
    SourceMap out;
    out.xx = double(width) / classes.width;
    out.yy = double(height) / classes.height;
    return out;
  }

  const WriterSettings& settings_;
  const ResultReader& reader_;
  const ResultFrame& frame_;
  const FrameFacts& facts_;
  std::string& out_;
  std::string label_;
  std::vector<int32_t> number_;  // of each object among the detections; -1 = it is none
};

class JsonWriter final : public RecordWriter {
 public:
  using RecordWriter::RecordWriter;
  bool write(const ResultReader& reader, const ResultFrame& frame, const FrameFacts& facts,
             std::string* out) override {
    FrameWriter(settings_, reader, frame, facts, out).write();
    return true;
  }
};

}  // namespace

std::unique_ptr<RecordWriter> json_writer(WriterSettings settings) {
  return std::make_unique<JsonWriter>(std::move(settings));
}

}  // namespace weir::records
