// Writes results as WebVTT captions: a cue with the labels and texts of each frame.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include <cmath>

#include "core/records/record_text.hpp"
#include "core/records/record_writer.hpp"
#include "weir/label_file.hpp"

namespace weir::records {
namespace {

constexpr int64_t kMillisecond = 1000000;
// The duration of a cue where neither the frame nor the stream has one.
constexpr int64_t kOtherwise = 40 * kMillisecond;

void append_digits(int64_t number, int digits, std::string* out) {
  const std::string text = std::to_string(number);
  for (int i = static_cast<int>(text.size()); i < digits; ++i) out->push_back('0');
  *out += text;
}

// hh:mm:ss.mmm
void append_time(int64_t nanoseconds, std::string* out) {
  const int64_t time = nanoseconds / kMillisecond;
  append_digits(time / 3600000, 2, out);
  out->push_back(':');
  append_digits(time / 60000 % 60, 2, out);
  out->push_back(':');
  append_digits(time / 1000 % 60, 2, out);
  out->push_back('.');
  append_digits(time % 1000, 3, out);
}

// One line of a cue: markup is escaped, and line breaks and other control characters are blanks.
void append_cue_text(std::string_view text, std::string* out) {
  while (!text.empty()) {
    const size_t length = utf8_sequence(text);
    if (length == 0)
      *out += "\xEF\xBF\xBD";
    else if (text[0] == '&')
      *out += "&amp;";
    else if (text[0] == '<')
      *out += "&lt;";
    else if (text[0] == '>')
      *out += "&gt;";
    else if (length == 1 && static_cast<unsigned char>(text[0]) < ' ')
      out->push_back(' ');
    else
      out->append(text.substr(0, length));
    text.remove_prefix(std::max<size_t>(length, 1));
  }
}

class WebvttWriter final : public RecordWriter {
 public:
  using RecordWriter::RecordWriter;

  // A cue needs a time and a text.
  bool write(const ResultReader& reader, const ResultFrame& frame, const FrameFacts& facts,
             std::string* out) override {
    const size_t before = out->size();
    if (is_first_) *out += "WEBVTT\n\n";
    is_first_ = false;
    std::string lines;
    for (const ResultObject& object : frame.objects) append_line(reader, object, &lines);
    if (!lines.empty() && facts.running_time >= 0) {
      append_time(facts.running_time, out);
      *out += " --> ";
      // A cue of no length is not valid.
      const int64_t duration =
          std::max(facts.duration > 0 ? facts.duration : kOtherwise, kMillisecond);
      append_time(std::min(facts.running_time, INT64_MAX - duration) + duration, out);
      *out += '\n' + lines + '\n';
    }
    return out->size() > before;
  }
  void restart() noexcept override { is_first_ = true; }

 private:
  // "person 91 %", "person #3 91 %" or a text.
  void append_line(const ResultReader& reader, const ResultObject& object, std::string* out) const {
    if (!(object.score >= settings_.threshold)) return;
    std::string number, line;
    if (get_kind(reader, object) == RowKind::Text) {
      append_cue_text(object.text, &line);
      if (line.find_first_not_of(' ') == std::string::npos) return;
    } else {
      const uint32_t source = reader.groups()[object.group].source;
      append_cue_text(settings_.labels.of(source, std::max(object.class_index, 0), &number), &line);
      if (object.track > 0) line += " #" + std::to_string(object.track);
      const float percent = 100 * std::min(object.score, 1.0f);
      line += ' ' + std::to_string(std::lround(percent)) + " %";
    }
    *out += line + '\n';
  }

  bool is_first_ = true;
};

}  // namespace

std::unique_ptr<RecordWriter> webvtt_writer(WriterSettings settings) {
  return std::make_unique<WebvttWriter>(std::move(settings));
}

}  // namespace weir::records
