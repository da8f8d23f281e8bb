// Writes detections as entries of COCO's list of results, one a line.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cmath>

#include "core/records/record_text.hpp"
#include "core/records/record_writer.hpp"
#include "core/records/run_lengths.hpp"

namespace weir::records {
namespace {

// The ids of COCO's 80 classes: 1 to 90 without these ten.
constexpr int32_t kUnused[] = {12, 26, 29, 30, 45, 66, 68, 69, 71, 83};
constexpr int32_t kClasses = 80;

int32_t coco_id(int32_t index) {
  int32_t id = index + 1;
  for (const int32_t unused : kUnused) id += id >= unused;
  return id;
}

class CocoWriter final : public RecordWriter {
 public:
  using RecordWriter::RecordWriter;

  // Frames are counted from 0.
  bool write(const ResultReader& reader, const ResultFrame& frame, const FrameFacts& facts,
             std::string* out) override {
    const size_t before = out->size();
    const int64_t image = image_++;
    for (const ResultObject& object : frame.objects)
      if (get_kind(reader, object) == RowKind::Detection && object.score >= settings_.threshold)
        write_entry(image, frame, object, facts, out);
    return out->size() > before;
  }
  void restart() noexcept override { image_ = 0; }

 private:
  int32_t get_category(int32_t index) const {
    return settings_.has_coco_ids && index >= 0 && index < kClasses ? coco_id(index)
                                                                    : std::max(index, 0);
  }

  void write_entry(int64_t image, const ResultFrame& frame, const ResultObject& object,
                   const FrameFacts& facts, std::string* out) const {
    const Box& box = object.box;
    *out += "{\"image_id\":";
    append_number(image, out);
    *out += ",\"category_id\":";
    append_number(int64_t{get_category(object.class_index)}, out);
    *out += ",\"bbox\":";
    char separator = '[';
    for (const float number : {box.x1, box.y1, box.width(), box.height()}) {
      out->push_back(separator);
      append_number(number, out);
      separator = ',';
    }
    *out += "],\"score\":";
    append_number(object.score, out);
    if (!object.mask.values.empty() && has_run_lengths(facts.width, facts.height)) {
      *out += ",\"segmentation\":";
      append_mask(runs_of_mask(object.mask, box, facts.width, facts.height), facts.width,
                  facts.height, out);
    }
    if (object.n_points > 0) write_points(frame, object, out);
    *out += "}\n";
  }

  // x, y and visibility: 0, 0, 0 for a point that was not found.
  static void write_points(const ResultFrame& frame, const ResultObject& object, std::string* out) {
    *out += ",\"keypoints\":";
    char separator = '[';
    for (uint32_t i = 0; i < object.n_points; ++i) {
      const results::KeyPoint& point = frame.points[object.first_point + i];
      const bool found = std::isfinite(point.x) && std::isfinite(point.y) && point.score > 0;
      for (const float number : {found ? point.x : 0, found ? point.y : 0, found ? 1.0f : 0}) {
        out->push_back(separator);
        append_number(number, out);
        separator = ',';
      }
    }
    out->push_back(']');
  }

  int64_t image_ = 0;
};

}  // namespace

std::unique_ptr<RecordWriter> coco_writer(WriterSettings settings) {
  return std::make_unique<CocoWriter>(std::move(settings));
}

}  // namespace weir::records
