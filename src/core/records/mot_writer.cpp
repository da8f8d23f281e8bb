// Writes detections and tracks as lines of MOTChallenge: frame, id, box, confidence, class,
// visibility. Frames, classes and coordinates count from 1.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/records/record_text.hpp"
#include "core/records/record_writer.hpp"

namespace weir::records {
namespace {

class MotWriter final : public RecordWriter {
 public:
  using RecordWriter::RecordWriter;

  bool write(const ResultReader& reader, const ResultFrame& frame, const FrameFacts&,
             std::string* out) override {
    const size_t before = out->size();
    ++frame_;
    for (const ResultObject& object : frame.objects)
      if (get_kind(reader, object) == RowKind::Detection && object.score >= settings_.threshold)
        write_line(object, out);
    return out->size() > before;
  }
  void restart() noexcept override { frame_ = 0; }

 private:
  void write_line(const ResultObject& object, std::string* out) const {
    const Box& box = object.box;
    append_number(frame_, out);
    out->push_back(',');
    append_number(object.track > 0 ? int64_t{object.track} : -1, out);
    for (const float number : {box.x1 + 1, box.y1 + 1, box.width(), box.height(), object.score}) {
      out->push_back(',');
      append_number(number, out);
    }
    out->push_back(',');
    append_number(int64_t{std::max(object.class_index, 0)} + 1, out);
    *out += ",1\n";  // visibility is not known: visible
  }

  int64_t frame_ = 0;
};

}  // namespace

std::unique_ptr<RecordWriter> mot_writer(WriterSettings settings) {
  return std::make_unique<MotWriter>(std::move(settings));
}

}  // namespace weir::records
