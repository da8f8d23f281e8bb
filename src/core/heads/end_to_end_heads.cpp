// Reads rows of objects.
// SPDX-License-Identifier: LGPL-2.1-or-later
#include "core/heads/end_to_end_heads.hpp"

#include "core/heads/coordinates.hpp"

namespace weir::heads {
namespace {

using detection::Candidates;
using detection::PictureSize;

constexpr size_t kMostRows = 1000;  // that fit() takes for rows of objects

// The index of each number in a row. The numbers of the box are together.
struct Columns {
  size_t length = 0, box = 0, score = 0, class_index = 0;
  std::optional<size_t> picture{};  // number of the picture in a batch; below 0 ends the rows
};
constexpr Columns kYolov10Columns{.length = 6, .box = 0, .score = 4, .class_index = 5};
constexpr Columns kYolov7Columns{.length = 7, .box = 1, .score = 6, .class_index = 5, .picture = 0};
constexpr Columns kOutputColumns{.length = 7, .box = 3, .score = 2, .class_index = 1, .picture = 0};

class EndToEnd final : public Head {
 public:
  EndToEnd(const Columns& columns, PictureSize input, Unit unit, float threshold)
      : columns_(columns), input_(input), boxes_(unit, threshold) {}

  results::Features features() const override { return {}; }

  Candidates find(OutputValues& outputs, PictureSize input) override {
    const auto numbers = outputs.read(0);
    boxes_.begin();
    for (size_t i = 0; i < numbers.size() / columns_.length; ++i) {
      const auto row = numbers.subspan(i * columns_.length, columns_.length);
      if (columns_.picture && row[*columns_.picture] < 0) break;
      boxes_.add(row.subspan(columns_.box).first<4>(), row[columns_.score],
                 row[columns_.class_index], i);
    }
    return boxes_.take(input.width > 0 ? input : input_);
  }

 private:
  const Columns& columns_;
  PictureSize input_;
  CornerBoxes boxes_;
};

// One output of rows of this length; the rows of a batch of one picture.
bool has_rows(const ModelFacts& model, const Columns& columns) {
  if (model.outputs.size() != 1) return false;
  const Shape& shape = model.outputs[0].shape;
  const auto count = shape.count();
  return shape[0] == columns.length && shape.min_rank() <= 3 && count && *count > 0;
}
Fit fit_rows(const ModelFacts& model, const Columns& columns) {
  if (!has_rows(model, columns)) return Fit::No;
  return *model.outputs[0].shape.count() / columns.length <= kMostRows ? Fit::Possible : Fit::No;
}
std::unique_ptr<Head> open_rows(const ModelFacts& model, const HeadOptions& options,
                                const Family& family, const Columns& columns) {
  if (!has_rows(model, columns)) throw wrong_outputs(model, family);
  return std::make_unique<EndToEnd>(columns, model.input, unit_setting(options), options.threshold);
}

}  // namespace

const Family kYolov10{
    .name = "yolov10",
    .aliases = "yolo26,end-to-end",
    .tasks = kDetection,
    .outputs = "1 tensor 6:N of x1, y1, x2, y2, score, class",
    .custom = "unit",
    .threshold = 0.25f,
    .fit = [](const ModelFacts& model) { return fit_rows(model, kYolov10Columns); },
    .open =
        [](const ModelFacts& model, const HeadOptions& options) {
          return open_rows(model, options, kYolov10, kYolov10Columns);
        }};

const Family kYolov7EndToEnd{
    .name = "yolov7-end2end",
    .aliases = "",
    .tasks = kDetection,
    .outputs = "1 tensor 7:N of picture, x1, y1, x2, y2, class, score",
    .custom = "unit",
    .threshold = 0.25f,
    .fit = [](const ModelFacts& model) { return fit_rows(model, kYolov7Columns); },
    .open =
        [](const ModelFacts& model, const HeadOptions& options) {
          return open_rows(model, options, kYolov7EndToEnd, kYolov7Columns);
        }};

const Family kDetectionOutput{
    .name = "detection-output",
    .aliases = "openvino,caffe-ssd",
    .tasks = kDetection,
    .outputs = "1 tensor 7:N of picture, class, score, x1, y1, x2, y2",
    .custom = "unit",
    .threshold = 0.5f,
    .fit = [](const ModelFacts& model) { return fit_rows(model, kOutputColumns); },
    .open =
        [](const ModelFacts& model, const HeadOptions& options) {
          return open_rows(model, options, kDetectionOutput, kOutputColumns);
        }};

}  // namespace weir::heads
